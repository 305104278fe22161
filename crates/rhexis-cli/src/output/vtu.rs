//! One body at one moment as a ParaView file (.vtu): triangles with displacement, stress, fibre and criterion.
//!
//! Values are `f64` in little-endian base64 blocks, so reading a file back gives the same bits.

use super::{OutputError, file, shape};
use glam::DVec3;
use rhexis::frame::BodyFrame;
use std::path::Path;
use vtkio::IOBuffer;
use vtkio::model::{
    Attribute, Attributes, ByteOrder, CellType, Cells, DataSet, UnstructuredGridPiece, Version, VertexNumbers, Vtk,
};

/// A grid without cells: vtkio leaves out counts that are zero, and VTK then refuses the file. The arrays are a block
/// header saying zero bytes.
const EMPTY: &str = r#"<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid><Piece NumberOfPoints="0" NumberOfCells="0"><PointData/><CellData/>
<Points><DataArray type="Float64" Name="Points" NumberOfComponents="3" format="binary">AAAAAAAAAAA=</DataArray></Points>
<Cells><DataArray type="Int64" Name="connectivity" format="binary">AAAAAAAAAAA=</DataArray>
<DataArray type="Int64" Name="offsets" format="binary">AAAAAAAAAAA=</DataArray>
<DataArray type="UInt8" Name="types" format="binary">AAAAAAAAAAA=</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>
"#;

/// Writes one body as an unstructured grid.
///
/// Point data: `displacement` \[mm\] and, where the frame holds them, `velocity` \[mm/ms\] and `force` \[N\]. Cell data: `stress` (9 components by rows, \[MPa\]), `principal_stress` (2, \[MPa\]),
/// `fibre` (3) and, for a body that can tear, `criterion`. A body without triangles gives a valid, empty grid.
///
/// # Errors
/// The arrays of the body do not belong together, or the file cannot be written.
pub fn write_vtu(path: &Path, body: &BodyFrame) -> Result<(), OutputError> {
    shape::check_shape(path, body)?;
    if body.triangles.is_empty() {
        return file::replace(path, EMPTY.as_bytes());
    }
    let mut bytes = Vec::new();
    grid(body).write_xml(&mut bytes).map_err(|source| OutputError::content(path, source.to_string()))?;
    file::replace(path, &bytes)
}

fn grid(body: &BodyFrame) -> Vtk {
    let points: Vec<f64> = body.positions.iter().flat_map(|x| x.to_array()).collect();
    let displacement: Vec<f64> =
        body.positions.iter().zip(&body.rest_positions).flat_map(|(x, rest)| (*x - *rest).to_array()).collect();
    let stress: Vec<f64> = body.stress.iter().flat_map(|s| s.transpose().to_cols_array()).collect();
    let principal: Vec<f64> = body.principal_stress.iter().flat_map(|p| p.to_array()).collect();
    let fibres: Vec<f64> = body.fibres.iter().flat_map(|f| f.to_array()).collect();

    let flat = |vectors: &[DVec3]| vectors.iter().flat_map(|v| v.to_array()).collect::<Vec<f64>>();
    let mut point = vec![array("displacement", 3, displacement)];
    for (name, vectors) in [("velocity", &body.velocities), ("force", &body.forces)] {
        // As below: of the right length or not at all.
        if vectors.len() == body.positions.len() {
            point.push(array(name, 3, flat(vectors)));
        }
    }
    let mut cell = vec![array("stress", 9, stress), array("principal_stress", 2, principal), array("fibre", 3, fibres)];
    // An array of the wrong length makes ParaView refuse the file, so a body that cannot tear has none.
    if body.criterion.len() == body.triangles.len() {
        cell.push(array("criterion", 1, body.criterion.clone()));
    }

    Vtk {
        // The first version with 64-bit block headers, which vtkio writes.
        version: Version::new((1, 0)),
        byte_order: ByteOrder::LittleEndian,
        title: body.name.clone(),
        file_path: None,
        data: DataSet::inline(UnstructuredGridPiece {
            points: IOBuffer::F64(points),
            cells: Cells {
                cell_verts: VertexNumbers::XML {
                    connectivity: body.triangles.iter().flatten().map(|&v| u64::from(v)).collect(),
                    offsets: (1..=body.triangles.len() as u64).map(|k| 3 * k).collect(),
                },
                types: vec![CellType::Triangle; body.triangles.len()],
            },
            data: Attributes { point, cell },
        }),
    }
}

fn array(name: &str, components: u32, values: Vec<f64>) -> Attribute {
    Attribute::generic(name, components).with_data(IOBuffer::F64(values))
}
