"""Lens tables as cameras on a set export them: the columns are real, the values are made up."""

ARRI = (
    "Index\tMaster TC\tProject FPS\tLens Squeeze\tLens Model\tLens Distance Unit\t"
    "Lens Focus Distance\tLens Focal Length\tLens Iris\tLens Linear Iris\n"
    "0\t13:36:49:07\t24.000\t1.000\tSome 40\tMeter\t4.812\t40.000\t1.4 + 7/10\t2667\n"
    "1\t13:36:49:08\t24.000\t1.000\tSome 40\tMeter\t4.500\t40.000\t1.4 + 7/10\t2667\n"
    "2\t13:36:49:09\t24.000\t1.000\tSome 40\tMeter\t4.100\t40.000\t1.4 + 7/10\t2667\n"
)
RED = (
    "FrameNo,Timecode,Timestamp,Aperture,Focus Distance,Focal Length,Acceleration X\n"
    "0,23:17:21:08,,5.600000,410,40,0.031\n"
    "1,23:17:21:09,,5.600000,420,40,0.031\n"
)
SONY = (
    '"Timecode","Lens Model","Focal Length (mm)","Aperture","Focus Distance (ft)"\n'
    '"16:47:04:19","7032","32","T 2 3/10","5.83"\n'
    '"16:47:04:20","7032","32","T 2 3/10","5.9"\n'
)
OWN = "frame;focus (cm);f-stop;zoom\n1001;250;2.8;35\n1002;inf;2.8;\n1004;200;--;50\n"
SHOOT_TABLES = {"arri": ARRI, "red": RED, "sony": SONY, "own": OWN}
