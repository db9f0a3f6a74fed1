#!/usr/bin/python3
"""VTK reads the cages that umax exports: sound hexes, energies and ratios that add up to what steps.csv says, times.

usage: vtk_cages.py PROGRAM
"""
import csv
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import vtk

sys.path.insert(0, str(Path(__file__).parent))
import clients  # noqa: E402


def read(path):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    errors = []
    reader.AddObserver("ErrorEvent", lambda *_: errors.append(path))
    reader.Update()
    assert not errors, f"{path}: VTK could not read it"
    return reader.GetOutput()


def volume_of(grid):
    """of all hexes; none may be turned inside out"""
    quality = vtk.vtkMeshQuality()
    quality.SetInputData(grid)
    quality.SetHexQualityMeasureToVolume()
    quality.Update()
    volumes = quality.GetOutput().GetCellData().GetArray("Quality")
    volumes = [volumes.GetTuple1(e) for e in range(grid.GetNumberOfCells())]
    assert min(volumes) > 0, "a hex is inside out"
    return sum(volumes)


def column(grid, name):
    array = grid.GetCellData().GetArray(name)
    return [array.GetTuple(e) for e in range(grid.GetNumberOfCells())]


def check_stress(grid):
    for tensor, mises in zip(column(grid, "stress"), column(grid, "von_mises")):
        xx, yy, zz, xy, yz, xz = tensor
        squared = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy ** 2 + yz ** 2 + xz ** 2)
        assert abs(squared ** 0.5 - mises[0]) <= 1e-9 * (1 + mises[0])


def test(umax, folder):
    export = umax.export("vtu", "--up", "z", "--scale", "10")
    steps = {int(row["frame"]): row for row in csv.DictReader(open(folder / "clip/steps.csv"))}
    entries = xml.parse(export / "cages.pvd").getroot().findall("Collection/DataSet")
    assert len(entries) == 2 * clients.FRAMES
    for entry in entries:
        assert (export / entry.get("file")).is_file(), entry.attrib
        assert abs(float(entry.get("timestep")) - (int(Path(entry.get("file")).stem) - 1) / clients.FPS) < 1e-12

    worked = 0
    for frame in range(1, clients.FRAMES + 1):
        grids = [read(export / name / f"{frame:04}.vtu") for name in ("ball", "cube")]
        assert [grid.GetNumberOfCells() for grid in grids] == [8, 8]
        for body, grid in enumerate(grids):
            assert grid.GetCellType(0) == vtk.VTK_HEXAHEDRON
            assert {row[0] for row in column(grid, "body")} == {float(body)}
            assert abs(grid.GetFieldData().GetArray("TimeValue").GetTuple1(0) - (frame - 1) / clients.FPS) < 1e-9
            check_stress(grid)
        volume = volume_of(grids[1])
        if frame == 1:
            rest = volume
            assert 64 < rest < 4 * 64, rest  # boxes around a cube of 4 units that is turned
            continue
        assert 0.7 < volume / rest < 1.4, volume
        energy = sum(row[0] for grid in grids for row in column(grid, "energy"))
        wanted = float(steps[frame]["elastic_energy_J"])
        assert abs(energy - wanted) <= 1e-4 * max(wanted, 1e-6), (frame, energy, wanted)
        ratio = max(row[0] for grid in grids for row in column(grid, "energy_ratio"))
        assert abs(ratio - float(steps[frame]["max_energy_ratio"])) < 1e-4, (frame, ratio)
        worked = max(worked, ratio)
        # z is up: what falls has a velocity along it
        if frame == 4:
            assert grids[0].GetPointData().GetArray("velocity").GetTuple(0)[2] < -3
    assert worked > 0.5, "the limits have nothing to do"


if __name__ == "__main__":
    clients.main(test)
