// The line to heatlens: one WebSocket, which comes back by itself.
//
// Text messages are JSON; binary ones are a line of JSON and a picture file. The next picture is
// sent once this one is acknowledged, so that nothing ever queues.

const VERSION = 1;
const AGAIN_MS = 500;
const ENDED = 1001;

export class Link {
  /** `hears` has the functions `hello`, `state`, `problem`, `picture` and `line`. */
  constructor(hears) {
    this.state = {};
    this.role = "look";
    this.name = "";
    this.isOpen = false;
    this._hears = hears;
    this._width = 0;
    this._connect();
    addEventListener("online", () => this._hurry());
    document.addEventListener("visibilitychange", () => document.hidden || this._hurry());
  }

  /** Send a message; while the line is cut, it is dropped: what was meant then is over. */
  send(message) {
    if (this.isOpen) this._socket.send(JSON.stringify(message));
  }

  do(name, values = {}) {
    this.send({ do: name, ...values });
  }

  change(of, values) {
    this.send({ change: of, ...values });
  }

  /** Tell how many pixels wide the picture is shown. */
  resize(width) {
    const rounded = Math.ceil(width / 64) * 64;
    if (rounded === this._width) return;
    this._width = rounded;
    this.send({ width_px: rounded });
  }

  _connect() {
    clearTimeout(this._again);
    const address = new URL("socket", location.href);
    address.protocol = address.protocol.replace("http", "ws");
    const socket = new WebSocket(address);
    this._socket = socket;
    socket.binaryType = "blob";
    socket.onopen = () => this._greet();
    socket.onmessage = (event) => this._hear(event.data);
    socket.onclose = (event) => this._cut(socket, event);
  }

  _greet() {
    const name = `${navigator.userAgentData?.platform || navigator.platform || "tablet"}`;
    this._socket.send(JSON.stringify({ hello: VERSION, width_px: this._width || 1280, name }));
  }

  _cut(socket, event) {
    if (socket !== this._socket) return;
    this.isOpen = false;
    this._hears.line(false, event.code === ENDED ? event.reason : "");
    this._again = setTimeout(() => this._connect(), AGAIN_MS);
  }

  /** Do not wait for a line that may have been cut while the tablet slept. */
  _hurry() {
    if (this._socket.readyState === WebSocket.OPEN) return;
    this._socket.onclose = null;
    this._socket.close();
    this._connect();
  }

  _hear(data) {
    if (data instanceof Blob) {
      this._take(data);
      return;
    }
    const said = JSON.parse(data);
    if (said.hello) {
      ({ role: this.role, you: this.name } = said);
      this.isOpen = true;
      this._hears.hello(said);
      this._hears.line(true, "");
    }
    if (said.problem) this._hears.problem(said.problem);
    if (said.state) {
      Object.assign(this.state, said.state);
      this._hears.state(said.state);
    }
  }

  async _take(blob) {
    const socket = this._socket;
    const head = await headOf(blob);
    try {
      const bitmap = await createImageBitmap(blob.slice(head.bytes, blob.size, head.type));
      this._hears.picture(bitmap, head);
    } finally {
      if (socket.readyState === WebSocket.OPEN) {
        socket.send(JSON.stringify({ got: head.picture }));
      }
    }
  }
}

const HEAD_MOST = 512;

async function headOf(blob) {
  const bytes = new Uint8Array(await blob.slice(0, HEAD_MOST).arrayBuffer());
  const end = bytes.indexOf(10);
  const head = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
  return { ...head, bytes: end + 1 };
}
