"""Check that a lens parameter added in one place reaches commands, shot files and the timeline.

Members of an enumeration cannot be added from outside, so the test edits a copy of the program.
"""

from support.program_copies import copy_program, run_in_copy

_HOME = "app/heatlens/core/model/shot/lens_parameter.py"
_RECORD = """    LensParameter.RIM: ParameterFacts(
        scales=(Scale.LINEAR,), labels=((-1.0, 0.0, 1.0),), span_least=0.1, sign="{} rims",
    ),
}
"""
EDITS = {
    _HOME: {
        '    SPLIT = "split_dioptres"\n': '    SPLIT = "split_dioptres"\n    RIM = "rim"\n',
        '        sign="{} D",\n    ),\n}\n': f'        sign="{{}} D",\n    ),\n{_RECORD}',
    },
    "app/heatlens/core/model/shot/shot.py": {
        "    split_dioptres: Curve = field(default_factory=Curve)\n": """
    split_dioptres: Curve = field(default_factory=Curve)
    rim: Curve = field(default_factory=Curve)
"""
    },
}


def test_added_lens_parameter_works_in_commands_files_and_timeline(tmp_path):
    process = run_in_copy(
        copy_program(tmp_path, EDITS),
        """
        from heatlens.fronts.commands.main import main
        from heatlens.media.documents.shot_file import read_shot
        from heatlens.core.model.keys.key_rows import shown_rows
        from heatlens.core.model.shot.lens_parameter import LensParameter
        from heatlens.studio.ui.timeline.curve_axis import AXES
        words = "shot new a.####.exr -o a.heatlens.json --focal-length 50 --sensor-width 36".split()
        words += "--f-stop 2 --focus-distance 3 --key rim@1=0 --key rim@9=0.5 --frames 1-9".split()
        assert main(words) == 0
        shot = read_shot(folder / "a.heatlens.json")
        assert shot.lens_at(9).rim == 0.5 and shot.lens_at(1).rim == 0.0
        rim = LensParameter.RIM
        assert rim in shown_rows(shot, False) and rim.control == "rim"
        assert AXES[rim].format_value(0.5, "m") == "0.5 rims"
        assert main(["shot", "show", "a.heatlens.json"]) == 0
        """,
    )
    assert "0.5 rims" in process.stdout
