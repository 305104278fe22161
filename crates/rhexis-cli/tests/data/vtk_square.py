# Writes the unit square in the encodings of VTK's own writers: python3 vtk_square.py (needs the package vtk).
import vtk

points = vtk.vtkPoints()
points.SetDataTypeToDouble()
for p in [(0, 0, 0), (1, 0, 0), (1, 1, 0.25), (0, 1, 0)]:
    points.InsertNextPoint(p)
grid = vtk.vtkUnstructuredGrid()
grid.SetPoints(points)
fibre = vtk.vtkFloatArray()
fibre.SetName("fibre")
fibre.SetNumberOfComponents(3)
for corners, direction in [((0, 1, 2), (1, 0, 0)), ((0, 2, 3), (0, 2, 0))]:
    grid.InsertNextCell(vtk.VTK_TRIANGLE, 3, corners)
    fibre.InsertNextTuple3(*direction)
grid.GetCellData().AddArray(fibre)


def write(name, mode, zlib, base64):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(name)
    writer.SetDataMode(mode)
    writer.SetCompressorTypeToZLib() if zlib else writer.SetCompressorTypeToNone()
    writer.SetBlockSize(32)  # bytes: even this small file then has arrays of several blocks
    writer.SetEncodeAppendedData(base64)
    writer.Write()


write("appended_raw_zlib.vtu", vtk.vtkXMLWriter.Appended, True, False)
write("appended_base64.vtu", vtk.vtkXMLWriter.Appended, False, True)
write("inline_zlib.vtu", vtk.vtkXMLWriter.Binary, True, False)
for name, binary in [("legacy_text.vtk", False), ("legacy_binary.vtk", True)]:
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(name)
    writer.SetFileTypeToBinary() if binary else writer.SetFileTypeToASCII()
    writer.Write()
