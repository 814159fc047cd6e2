# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in ParaView: bent as it moves, coloured by von Mises stress, one scale from 0 to the largest stress of all times.

    pvpython paraview_stress.py RESULTS.xdmf PICTURE.png [TIME [FACTOR]]
    paraview --script=paraview_stress.py             opens $CBR_FIELDS in the window

RESULTS: the fields of `output: {fields: [displacement, stress]}`, .xdmf or .exo. TIME: by default that of the largest stress. FACTOR:
displacements are drawn so many times larger (1). Without a display: xvfb-run -a -s -noreset pvpython ... Written for ParaView 5.11.
"""
import os
import sys

from paraview import simple

STRESS = "stress_von_mises"


def open_fields(path):
    """The reader of the run, all arrays on; nothing moved yet."""
    if not os.path.isfile(path):
        sys.exit(f"{path}: no such file: give the .xdmf or .exo beside the results of cbr-dyn")
    if not path.endswith((".xdmf", ".exo")):
        sys.exit(f"{path}: expected fields of cbr-dyn, .xdmf or .exo")
    data = os.path.splitext(path)[0] + ".fields.h5"
    if path.endswith(".xdmf") and not os.path.isfile(data):
        sys.exit(f"{data}: no such file: it holds the numbers of {path}, keep them in one folder")
    if path.endswith(".exo"):
        reader = simple.ExodusIIReader(FileName=[path])
        reader.ApplyDisplacements = 0
        reader.ElementVariables.SelectAll()
        reader.PointVariables.SelectAll()
    else:
        reader = simple.XDMFReader(FileNames=[os.path.abspath(path)])
    reader.UpdatePipelineInformation()
    if not list(reader.TimestepValues):
        sys.exit(f"{path}: no fields over time: ask for output: {{fields: [displacement, stress]}}")
    return reader


def largest_stress(reader):
    """(stress, time) of the largest stress at any output."""
    found = (0.0, reader.TimestepValues[0])
    for time in reader.TimestepValues:
        reader.UpdatePipeline(time)
        array = reader.CellData.GetArray(STRESS)
        if array is None:
            sys.exit(f"no {STRESS} in the file: add stress to output.fields, and recovery: true to superelements")
        found = max(found, (array.GetRange()[1], time))
    return found


def show(path, time=None, factor=1.0):
    """The view, ready to look at."""
    reader = open_fields(path)
    largest, when = largest_stress(reader)
    displacement = next(name for name in reader.PointData.keys() if name.startswith("displacement"))
    bent = simple.WarpByVector(Input=reader, Vectors=["POINTS", displacement], ScaleFactor=factor)
    view = simple.GetActiveViewOrCreate("RenderView")
    view.ViewSize = [1000, 600]
    view.ViewTime = simple.GetTimeKeeper().Time = when if time is None else time
    display = simple.Show(bent, view)
    display.Representation = "Surface With Edges"
    display.EdgeColor, display.LineWidth = [0.3, 0.3, 0.3], 0.5
    display.Ambient, display.Diffuse = 0.6, 0.4  # little shade: colours are read against the scale
    simple.ColorBy(display, ("CELLS", STRESS))
    colours = simple.GetColorTransferFunction(STRESS)
    colours.AutomaticRescaleRangeMode = "Never"  # else each time has a scale of its own
    colours.ApplyPreset("Viridis (matplotlib)", True)
    colours.RescaleTransferFunction(0.0, largest)
    bar = simple.GetScalarBar(colours, view)
    bar.Title, bar.ComponentTitle = f"von Mises stress, t = {view.ViewTime:.3g}", ""
    bar.Orientation, bar.WindowLocation, bar.ScalarBarLength = "Horizontal", "Lower Center", 0.5
    bar.TitleColor = bar.LabelColor = [0, 0, 0]
    display.SetScalarBarVisibility(view, True)
    view.UseColorPaletteForBackground, view.Background = 0, [1, 1, 1]
    view.OrientationAxesLabelColor = [0, 0, 0]
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [0.45, -0.8, 0.45], [0, 0, 0], [0, 0, 1]
    simple.ResetCamera(view)
    simple.GetActiveCamera().Zoom(1.3)
    simple.Render(view)
    print(f"{path}: {len(reader.TimestepValues)} times, largest von Mises stress {largest:.6g} at t = {when:.6g}; shown: t = {view.ViewTime:.6g}")
    return view


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    time = float(sys.argv[3]) if len(sys.argv) > 3 else None
    factor = float(sys.argv[4]) if len(sys.argv) > 4 else 1.0
    simple.SaveScreenshot(sys.argv[2], show(sys.argv[1], time, factor))


if "CBR_FIELDS" in os.environ:
    show(os.environ["CBR_FIELDS"])
elif __name__ == "__main__":
    main()
