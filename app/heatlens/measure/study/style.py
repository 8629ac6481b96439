"""How a report looks: one sheet of paper, hairlines, one warm accent, no script."""

STYLE = """
:root { --paper: #fbfaf8; --ink: #1f1d1a; --soft: #6d6861; --line: #e3dfd8; --bar: #e9e4dc;
  --heat: #c2410c; --wash: #fdf3ec; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink); -webkit-text-size-adjust: 100%;
  font: 16px/1.55 ui-sans-serif, system-ui, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 1240px; margin: 0 auto; padding: 56px 32px 96px; }
h1 { font-size: 40px; line-height: 1.12; letter-spacing: -.02em; font-weight: 650; margin: 6px 0 0;
  overflow-wrap: anywhere; }
h2 { font-size: 22px; letter-spacing: -.01em; font-weight: 620; margin: 72px 0 4px; }
h3 { font-size: 17px; font-weight: 620; margin: 0; }
p { margin: 0; max-width: 68ch; }
.eyebrow { color: var(--heat); font-size: 13px; font-weight: 600; letter-spacing: .08em;
  text-transform: uppercase; }
.soft, figcaption { color: var(--soft); font-size: 14px; line-height: 1.45;
  font-weight: 400; }
.finding { font-size: 21px; line-height: 1.45; margin: 28px 0 0; max-width: 56ch; }
.finding b { font-weight: 620; color: var(--heat); }
.warning { margin: 28px 0 0; padding: 14px 18px; background: var(--wash); max-width: none;
  border-left: 3px solid var(--heat); border-radius: 0 6px 6px 0; }
.facts { display: flex; flex-wrap: wrap; gap: 14px 40px; margin: 32px 0 0; padding: 18px 0 0;
  border-top: 1px solid var(--line); }
.facts dt { color: var(--soft); font-size: 13px; }
.facts dd { margin: 0; overflow-wrap: anywhere; }
.wide { overflow-x: auto; margin-top: 20px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th { text-align: right; color: var(--soft); font-size: 13px; font-weight: 500; }
th, td { padding: 11px 0 11px 28px; border-bottom: 1px solid var(--line); text-align: right;
  white-space: nowrap; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
td:first-child a { color: inherit; font-weight: 600; text-decoration-color: var(--line);
  text-underline-offset: 4px; }
td:first-child span { color: var(--soft); font-size: 14px; margin-left: 8px; }
td.flip { min-width: 220px; }
.bar { display: inline-block; vertical-align: middle; width: 110px; height: 8px; margin-right: 14px;
  background: var(--bar); border-radius: 4px; overflow: hidden; }
.bar i { display: block; height: 100%; background: #8d867c; border-radius: 4px; }
tr.best .bar i { background: var(--heat); }
tr.best td.flip b { color: var(--heat); }
td b { font-weight: 600; }
svg text { font: 13px ui-sans-serif, system-ui, "Segoe UI", Roboto, sans-serif; fill: var(--soft); }
svg .name { fill: var(--ink); font-weight: 600; }
.chart { display: block; width: 100%; min-width: 560px; max-width: 860px; height: auto; }
figure { margin: 0; }
figcaption { margin-top: 8px; }
figcaption b { color: var(--ink); font-weight: 600; }
img { display: block; width: 100%; height: auto; border-radius: 4px; background: #000; }
.map { position: relative; margin-top: 20px; max-width: 860px; }
.map a { position: absolute; border: 2px solid #fff; border-radius: 3px; color: #fff;
  outline: 1px solid rgb(0 0 0 / .55); font-size: 13px; line-height: 1; text-decoration: none; }
.map b { display: inline-block; padding: 3px 6px; background: var(--heat); }
.crops { display: grid; grid-template-columns: repeat(var(--columns), 1fr); gap: 18px 12px;
  margin: 14px 0 36px; }
.crops img { image-rendering: pixelated; aspect-ratio: 1; }
.crops .is-reference img { box-shadow: 0 0 0 2px var(--paper), 0 0 0 4px var(--heat); }
.place { margin-top: 24px; }
.method { padding: 32px 0 0; margin-top: 32px; border-top: 1px solid var(--line); }
.method header { display: flex; flex-wrap: wrap; gap: 4px 16px; align-items: baseline;
  margin-bottom: 14px; }
.three { display: grid; grid-template-columns: repeat(3, 1fr); gap: 16px; }
.flips { position: relative; overflow: hidden; border-radius: 4px; }
.flips .over { position: absolute; inset: 0; opacity: 0; }
.flips:hover .over, .flips:focus .over { opacity: 1; }
footer { margin-top: 88px; padding-top: 18px; border-top: 1px solid var(--line); }
footer p + p { margin-top: 8px; }
@media (max-width: 900px) {
  .crops { grid-template-columns: repeat(auto-fill, minmax(128px, 1fr)); } }
@media (max-width: 800px) { main { padding: 32px 18px 64px; } .three { grid-template-columns: 1fr; }
  h1 { font-size: 30px; } }
""".strip()
