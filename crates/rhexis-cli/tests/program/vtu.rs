//! ParaView files of bodies: the bytes of the format, bodies read back as they were, and damaged files refused.

use crate::bodies::{cap, sheet};
use glam::{DMat3, DVec2, DVec3};
use rhexis::frame::BodyFrame;
use rhexis_cli::output::{VtuError, read_vtu, write_vtu};
use std::path::{Path, PathBuf};

/// The file in `tests/data`, which VTK and meshio have read.
const TWO_TRIANGLES: &str = include_str!("../data/two_triangles.vtu");

fn multiples<const N: usize>(rows: usize, of: f64) -> Vec<[f64; N]> {
    (0..rows).map(|row| std::array::from_fn(|k| (row * N + k) as f64 * of)).collect()
}

fn vectors(rows: usize, of: f64) -> Vec<DVec3> {
    multiples(rows, of).into_iter().map(DVec3::from).collect()
}

/// The body of that file: with no number, infinity and negative zero.
fn two_triangles() -> BodyFrame {
    let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.25], [0.0, 1.0, -0.0]].map(DVec3::from).to_vec();
    let mut stress = multiples::<9>(2, 0.5);
    stress[1][0] = f64::NAN;
    BodyFrame {
        rest_positions: positions.iter().zip(vectors(4, 0.5)).map(|(x, u)| *x - u).collect(),
        positions,
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        velocities: vectors(4, 0.25),
        forces: vectors(4, -1.0),
        stress: stress.iter().map(|rows| DMat3::from_cols_array(rows).transpose()).collect(),
        principal_stress: multiples(2, 1.0).into_iter().map(DVec2::from).collect(),
        fibres: vectors(2, 1.0),
        criterion: vec![0.5, f64::INFINITY],
        ..BodyFrame::default()
    }
}

fn written(folder: &Path, body: &BodyFrame) -> PathBuf {
    let path = folder.join("body.vtu");
    write_vtu(&path, body).unwrap();
    path
}

fn refused(folder: &Path, bytes: &[u8]) -> VtuError {
    let path = folder.join("damaged.vtu");
    std::fs::write(&path, bytes).unwrap();
    let error = read_vtu(&path).unwrap_err();
    assert!(error.to_string().contains("damaged.vtu"), "{error}");
    error
}

#[test]
fn the_bytes_of_the_format_are_fixed() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), &two_triangles());
    assert_eq!(std::fs::read_to_string(path).unwrap(), TWO_TRIANGLES);
}

/// Corners are signed, as readers want them; files with unsigned ones, of earlier versions, are read as well.
#[test]
fn corners_are_signed_and_unsigned_ones_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), &two_triangles());
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(!text.contains("\"UInt64\" Name") && text.matches("\"Int64\" Name").count() == 2, "{text}");
    std::fs::write(&path, text.replace("\"Int64\" Name", "\"UInt64\" Name")).unwrap();
    assert_eq!(read_vtu(&path).unwrap().triangles, two_triangles().triangles);
}

/// Files hold all 64 bits, so equality is exact.
#[test]
fn a_body_reads_back_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    for body in [sheet().body, cap(), two_triangles()] {
        let read = read_vtu(&written(folder.path(), &body)).unwrap();
        assert_eq!(read.triangles, body.triangles);
        // By their text, which tells negative zero and is the same for every NaN.
        let values = |b: &BodyFrame| {
            let vectors = (&b.positions, &b.velocities, &b.forces, &b.fibres);
            format!("{vectors:?} {:?} {:?} {:?}", b.stress, b.principal_stress, b.criterion)
        };
        assert!(values(&read) == values(&body));
        // A position less its displacement, which is rounded twice.
        let size = body.positions.iter().chain(&body.rest_positions).map(|x| x.abs().max_element()).fold(0.0, f64::max);
        for (rest, was) in read.rest_positions.iter().zip(&body.rest_positions) {
            assert!((*rest - *was).abs().max_element() <= 2.0 * f64::EPSILON * size, "{rest} {was}");
        }
    }
}

#[test]
fn a_body_without_triangles_or_criterion_gives_a_readable_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = written(folder.path(), &BodyFrame::default());
    // VTK refuses a piece without counts.
    assert!(std::fs::read_to_string(&path).unwrap().contains("NumberOfPoints=\"0\" NumberOfCells=\"0\""));
    let read = read_vtu(&path).unwrap();
    assert!(read.positions.is_empty() && read.triangles.is_empty());
    let mut body = two_triangles();
    body.criterion.clear();
    body.velocities.clear();
    body.forces.clear();
    let read = read_vtu(&written(folder.path(), &body)).unwrap();
    assert!(read.criterion.is_empty() && read.velocities.is_empty() && read.forces.is_empty());
    assert_eq!(read.fibres, body.fibres);
}

#[test]
fn a_file_that_is_cut_off_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for length in (0..TWO_TRIANGLES.len()).step_by(3) {
        let error = refused(folder.path(), &TWO_TRIANGLES.as_bytes()[..length]);
        assert!(matches!(error, VtuError::File(_)), "{length}: {error}");
    }
}

/// A bit of the numbers gives other numbers; one of the structure an error.
#[test]
fn a_flipped_bit_gives_an_error_or_a_whole_body() {
    let folder = tempfile::tempdir().unwrap();
    let (path, mut refusals) = (folder.path().join("damaged.vtu"), 0);
    for place in (0..TWO_TRIANGLES.len()).step_by(3) {
        let mut bytes = TWO_TRIANGLES.as_bytes().to_vec();
        bytes[place] ^= 1 << (place % 8);
        std::fs::write(&path, bytes).unwrap();
        match read_vtu(&path) {
            Ok(body) => write_vtu(&folder.path().join("again.vtu"), &body).unwrap(),
            Err(error) => {
                refusals += 1;
                assert!(error.to_string().contains("damaged.vtu"), "{error}");
            }
        }
    }
    assert!(refusals > TWO_TRIANGLES.len() / 12, "{refusals}");
}

#[test]
fn wrong_counts_are_refused_by_the_name_of_the_array() {
    let folder = tempfile::tempdir().unwrap();
    let most = u64::MAX.to_string();
    for (from, to, words) in [
        ("NumberOfPoints=\"4\"", "NumberOfPoints=\"5\"", ["\"Points\"", "12 numbers where 5"]),
        ("NumberOfPoints=\"4\"", &format!("NumberOfPoints=\"{most}\""), ["\"Points\"", "save again"]),
        ("NumberOfCells=\"2\"", &format!("NumberOfCells=\"{most}\""), ["\"types\"", "save again"]),
        ("NumberOfCells=\"2\"", "NumberOfCells=\"3\"", ["\"types\"", "2 numbers where 3"]),
        ("\"3\">YAAAAAAAAAAA", "\"3\">YQAAAAAAAAAA", ["\"displacement\"", "broken or cut off"]),
        ("\"3\">YAAAAAAAAAAA", "\"3\">////////fwAA", ["\"displacement\"", "broken or cut off"]),
        ("\"3\">YAAAAAAAAAAA", "\"3\">SAAAAAAAAAAA", ["\"displacement\"", "9 numbers for 4 rows"]),
        ("\"3\">YAAAAAAAAAAA", "\"3\">QAAAAAAAAAAA", ["\"displacement\"", "2 components where 3 belong"]),
        ("\"displacement\"", "\"other\"", ["\"displacement\"", "missing; write the file again"]),
        ("\"fibre\"", "\"other\"", ["\"fibre\"", "missing; write the file again"]),
    ] {
        assert!(TWO_TRIANGLES.contains(from), "{from}");
        let error = refused(folder.path(), TWO_TRIANGLES.replacen(from, to, 1).as_bytes()).to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{from} → {to}: {error}");
    }
}

#[test]
fn what_is_no_body_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    // A quad is two triangles of one row.
    let quad = "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData>\
        <DataArray Name=\"displacement\" format=\"ascii\">0 0 0 0 0 0 0 0 0 0 0 0</DataArray></PointData><CellData>\
        <DataArray Name=\"fibre\" format=\"ascii\">1 0 0</DataArray></CellData><Points><DataArray format=\"ascii\">0 0 0 1 0 0 1 1 0 0 1 0\
        </DataArray></Points><Cells><DataArray Name=\"connectivity\" format=\"ascii\">0 1 2 3</DataArray><DataArray Name=\"offsets\" \
        format=\"ascii\">4</DataArray><DataArray Name=\"types\" format=\"ascii\">9</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>";
    let error = refused(folder.path(), quad.as_bytes());
    assert!(matches!(error, VtuError::Rows { array: "fibre", found: 1, wanted: 2, .. }), "{error}");
    let entity = "<!DOCTYPE a [<!ENTITY e \"1\">]><VTKFile>&e;</VTKFile>";
    for bytes in [entity.as_bytes(), b"", b"\0\xff", b"<VTKFile/>", b"solid"] {
        assert!(matches!(refused(folder.path(), bytes), VtuError::File(_)));
    }
    let missing = read_vtu(&folder.path().join("nowhere.vtu")).unwrap_err().to_string();
    assert!(missing.contains("nowhere.vtu") && missing.contains("check the path"), "{missing}");
}
