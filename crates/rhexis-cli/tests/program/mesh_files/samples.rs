//! The same two triangles in every format and encoding.

use std::fs;
use std::path::{Path, PathBuf};

use super::as_they_are::{MSH_2, VTP, glb};
use glam::{DVec3, dvec3};
use rhexis::storage::TriangleMesh;
use rhexis_scene::mesh_file::{MeshFileError, Reading, read_with};

pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

/// Writes a file and reads it as a mesh, its numbers as they are.
pub fn read_bytes(name: &str, bytes: impl AsRef<[u8]>) -> Result<TriangleMesh, MeshFileError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    read_with(&path, &AS_THEY_ARE).map(|file| file.mesh)
}

/// Numbers as they are, in files of metres too.
pub const AS_THEY_ARE: Reading =
    Reading { scale: Some(1.0), weld: None, repair: false, flip: false, fibres: None, arrays: Vec::new() };

/// The unit square as the triangles 0 1 2 and 0 2 3, raised by 0.25 at vertex 2.
pub fn square() -> TriangleMesh {
    TriangleMesh {
        positions: vec![DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, 0.25), DVec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        fibres: None,
    }
}

pub const OBJ: &str = "# a comment\no patch\nv 0 0 0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0.25\nv 0 1 0\nvt 0 0\nvn 0 0 1\n\
                   usemtl red\nf 1/1/1 2/1/1 3//1\ng other\nl 1 2\nf -4 -2 -1\n";

/// The square with texture coordinates, normals and colours of its own.
pub const DECORATED_OBJ: &str = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0.25 0 0 1\nv 0 1 0 1 1 1\nvt 0 0\nvt 1 0\nvt 1 1 0\nvt 0 1\n\
                   vn 0 0 1\nvn -0.1 0 1\nf 1/1/1 2/2/2 3/3/1\nf -4/-4/-1 -2/-2/-2 -1/-1/-1\n";

/// The same as PLY.
pub const DECORATED_PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                   property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\nproperty uchar red\n\
                   property uchar green\nproperty uchar blue\nproperty uchar alpha\nelement face 1\n\
                   property list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 0 0 255 0 0 255\n1 0 0 0 0 1 1 0 0 255 0 255\n\
                   1 1 0.25 0 0 1 1 1 0 0 255 255\n0 1 0 0 0 1 0 1 9 9 9 255\n4 0 1 2 3\n";

/// The same as glTF in text, with colours as normalized bytes and texture coordinates as normalized shorts.
pub fn decorated_gltf() -> Vec<u8> {
    let mut binary: Vec<u8> = [0_u16, 1, 2, 0, 2, 3].map(u16::to_le_bytes).concat();
    let floats = |list: Vec<f32>| list.into_iter().flat_map(f32::to_le_bytes).collect::<Vec<u8>>();
    binary.extend(floats(square().positions.iter().flat_map(|p| p.as_vec3().to_array()).collect()));
    binary.extend(floats([0.0, 0.0, 1.0].repeat(4)));
    binary.extend(
        [[0, 0], [65535, 0], [65535, 65535], [0, 65535_u16]].as_flattened().iter().flat_map(|v| v.to_le_bytes()),
    );
    binary.extend([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 255]);
    let data = base64::Engine::encode(&base64::engine::general_purpose::STANDARD, &binary);
    let accessor = |view: usize, component: usize, kind: &str, count: usize, normalized: bool| {
        format!(
            "{{\"bufferView\":{view},\"componentType\":{component},\"type\":\"{kind}\",\"count\":{count},\"normalized\":{normalized}}}"
        )
    };
    let accessors = [
        accessor(0, 5123, "SCALAR", 6, false),
        accessor(1, 5126, "VEC3", 4, false),
        accessor(2, 5126, "VEC3", 4, false),
        accessor(3, 5123, "VEC2", 4, true),
        accessor(4, 5121, "VEC4", 4, true),
    ];
    let views = [(0, 12), (12, 48), (60, 48), (108, 16), (124, 16)]
        .map(|(offset, length)| format!("{{\"buffer\":0,\"byteOffset\":{offset},\"byteLength\":{length}}}"));
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\"indices\":0,\"attributes\":\
         {{\"POSITION\":1,\"NORMAL\":2,\"TEXCOORD_0\":3,\"COLOR_0\":4}}}}]}}],\"accessors\":[{}],\"bufferViews\":[{}],\
         \"buffers\":[{{\"byteLength\":{},\"uri\":\"data:application/octet-stream;base64,{data}\"}}]}}",
        accessors.join(","),
        views.join(","),
        binary.len()
    )
    .into_bytes()
}

pub const MSH: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\nby hand\n$EndComments\n\
                   $Nodes\n2 4 7 12\n0 1 0 1\n12\n0 0 0\n2 1 0 3\n9\n7\n8\n1 0 0\n1 1 0.25\n0 1 0\n$EndNodes\n\
                   $Elements\n3 4 1 4\n0 1 15 1\n1 12\n1 1 1 1\n2 12 9\n2 1 2 2\n3 12 9 7\n4 12 7 8\n$EndElements\n";

pub const VTK: &str = "# vtk DataFile Version 3.0\nsquare\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n\
                   0 0 0 1 0 0\n1 1 0.25 0 1 0\nCELLS 3 11\n2 0 1\n3 0 1 2\n3 0 2 3\nCELL_TYPES 3\n3 5 5\n\
                   POINT_DATA 4\nSCALARS height float 1\nLOOKUP_TABLE default\n0 0 0.25 0\n\
                   CELL_DATA 3\nSCALARS part int\nLOOKUP_TABLE default\n1 2 2\nVECTORS fibre double\n9 9 9\n1 0 0\n0 2 0\n";

pub const VTU: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">
 <UnstructuredGrid><Piece NumberOfPoints="4" NumberOfCells="2">
  <PointData/><CellData><DataArray type="Float32" Name="fibre" NumberOfComponents="3" format="ascii">1 0 0 0 2 0</DataArray></CellData>
  <Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0.25 0 1 0</DataArray></Points>
  <Cells>
   <DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 0 2 3</DataArray>
   <DataArray type="Int64" Name="offsets" format="ascii">3 6</DataArray>
   <DataArray type="UInt8" Name="types" format="ascii">5 5</DataArray>
  </Cells></Piece></UnstructuredGrid>
</VTKFile>
"#;

pub const PLY: &str = "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty double y\nproperty float z\n\
                   property uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
                   0 0 0 255\n1 0 0 255\n1 1 0.25 255\n0 1 0 255\n4 0 1 2 3\n";

pub const STL: &str = "solid\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0.25\n  endloop\n endfacet\n \
                   facet normal 0 0 1\n  outer loop\n   vertex -0 0 0\n   vertex 1 1 0.25\n   vertex 0 1 0\n  endloop\n endfacet\nendsolid\n";

pub const OFF: &str = "OFF\n4 2 5\n0 0 0\n1 0 0\n1 1 0.25\n0 1 0\n3 0 1 2\n3 0 2 3\n";

pub fn binary_msh(big_endian: bool) -> Vec<u8> {
    let int = |x: i32| if big_endian { x.to_be_bytes() } else { x.to_le_bytes() };
    let size = |x: u64| if big_endian { x.to_be_bytes() } else { x.to_le_bytes() };
    let real = |x: f64| if big_endian { x.to_be_bytes() } else { x.to_le_bytes() };
    let mut out = b"$MeshFormat\n4.1 1 8\n".to_vec();
    out.extend(int(1));
    out.extend(b"\n$EndMeshFormat\n$Nodes\n");
    out.extend([1, 4, 1, 4].map(size).concat());
    out.extend([2, 1, 0].map(int).concat());
    // Dense tags in another order: the positions follow the tags' order here, not their values.
    out.extend([4, 4, 2, 1, 3].map(size).concat());
    let xyz = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.25], [0.0, 1.0, 0.0]];
    out.extend(xyz.concat().into_iter().flat_map(real));
    out.extend(b"\n$EndNodes\n$Elements\n");
    out.extend([1, 1, 1, 1].map(size).concat());
    out.extend([2, 1, 3].map(int).concat());
    out.extend([1, 1, 4, 2, 1, 3].map(size).concat());
    out.extend(b"\n$EndElements\n");
    out
}

fn binary_vtk() -> Vec<u8> {
    let mut out = b"# vtk DataFile Version 5.1\nsquare\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n".to_vec();
    let xyz = [0.0f32, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.25, 0.0, 1.0, 0.0];
    out.extend(xyz.map(f32::to_be_bytes).concat());
    out.extend(b"\nMETADATA\nINFORMATION 0\n\nPOLYGONS 3 6\nOFFSETS vtktypeint64\n");
    out.extend([0i64, 3, 6].map(i64::to_be_bytes).concat());
    out.extend(b"\nCONNECTIVITY vtktypeint64\n");
    out.extend([0i64, 1, 2, 0, 2, 3].map(i64::to_be_bytes).concat());
    out.extend(b"\nCELL_DATA 2\nFIELD FieldData 2\npart 1 2 unsigned_char\n\x01\x0a\nMETADATA\nINFORMATION 0\n\nfibre 3 2 float\n");
    out.extend([1.0f32, 0.0, 0.0, 0.0, 2.0, 0.0].map(f32::to_be_bytes).concat());
    out.extend(b"\n");
    out
}

pub fn binary_stl(header: &[u8]) -> Vec<u8> {
    let mut out = header.to_vec();
    out.resize(80, b' ');
    out.extend(2u32.to_le_bytes());
    let mesh = square();
    for triangle in mesh.triangles {
        out.extend([0u8; 12]);
        for corner in triangle {
            out.extend(mesh.positions[corner as usize].to_array().map(|x| (x as f32).to_le_bytes()).concat());
        }
        out.extend([0u8; 2]);
    }
    out
}

fn binary_ply(big_endian: bool) -> Vec<u8> {
    let order = if big_endian { "big" } else { "little" };
    let mut out = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
         element face 2\nproperty list uchar uint vertex_index\nend_header\n"
    )
    .into_bytes();
    let mesh = square();
    for p in mesh.positions {
        out.extend(p.to_array().map(|x| if big_endian { x.to_be_bytes() } else { x.to_le_bytes() }).concat());
    }
    for t in mesh.triangles {
        out.push(3);
        out.extend(t.map(|v| if big_endian { v.to_be_bytes() } else { v.to_le_bytes() }).concat());
    }
    out
}

/// One valid file per format and encoding: the seeds of the hostile tests.
pub fn good_files() -> Vec<(&'static str, Vec<u8>)> {
    let mut files: Vec<(&str, Vec<u8>)> =
        [("a.obj", OBJ), ("a.msh", MSH), ("a.vtk", VTK), ("a.vtu", VTU), ("a.ply", PLY), ("a.stl", STL)]
            .map(|(name, text)| (name, text.as_bytes().to_vec()))
            .to_vec();
    files.extend([("b.msh", binary_msh(false)), ("c.msh", binary_msh(true)), ("b.vtk", binary_vtk())]);
    files.extend([("b.ply", binary_ply(false)), ("c.ply", binary_ply(true))]);
    files.extend([("b.stl", binary_stl(b"made by hand")), ("c.stl", binary_stl(b"solid made by hand"))]);
    files.extend([("a.off", OFF.as_bytes().to_vec()), ("a.vtp", VTP.as_bytes().to_vec()), ("a.glb", glb())]);
    files.push(("d.msh", MSH_2.as_bytes().to_vec()));
    files.extend(
        [("b.obj", DECORATED_OBJ), ("d.ply", DECORATED_PLY)].map(|(name, text)| (name, text.as_bytes().to_vec())),
    );
    files.push(("a.gltf", decorated_gltf()));
    // By the writers of VTK itself (tests/data/README.md).
    let by_vtk =
        ["appended_raw_zlib.vtu", "appended_base64.vtu", "inline_zlib.vtu", "legacy_text.vtk", "legacy_binary.vtk"];
    for name in by_vtk {
        files.push((name, fs::read(data(name)).unwrap()));
    }
    files
}
