# SPDX-License-Identifier: GPL-3.0-or-later
"""Files and runs of the cbr programs, from Python.

    superelement(path)   matrices, dofs, faces, frequencies, shapes and responses of a superelement
    results(path)        the time series of a run, by name
    scene(...)           a scene: written to a file, and run by cbr-reduce, cbr-skin and cbr-dyn
    check_error(scene)   the error of a scene's reductions, against its full meshes
    study(scene, parameter, values)   a run for each value of one parameter, and a table of them
    cfc, butterworth, psd      filters without phase, and the spectrum, of a time series

Arrays have the units of the scene. docs/formats.md describes all files.
"""
from cbr.check import ErrorCheck, check_error
from cbr.results import Results, results
from cbr.scene import Failed, Scene, scene
from cbr.signals import butterworth, cfc, psd
from cbr.study import Study, study
from cbr.superelement import Faces, FileError, Superelement, superelement

__all__ = ["ErrorCheck", "Faces", "Failed", "FileError", "Results", "Scene", "Study", "Superelement",
           "butterworth", "cfc", "check_error", "psd", "results", "scene", "study", "superelement"]
__version__ = "0.1.0"
