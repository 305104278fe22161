//! Cut, damaged and lying files: an error or a mesh that passes its check, never a panic.

use super::samples::{MSH, PLY, VTK, VTU, binary_msh, binary_stl, good_files, read_bytes};

/// A small fixed-seed generator (Steele, Lea, Flood 2014, SplitMix64): the same bytes on every machine.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }
}

#[test]
fn truncated_files_never_panic() {
    for (name, bytes) in good_files() {
        for end in 0..bytes.len() {
            if let Ok(mesh) = read_bytes(name, &bytes[..end]) {
                assert_eq!(mesh.check(), Ok(()), "{name} cut at {end}");
            }
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let mut random = SplitMix(2009);
    let words = [
        "-1",
        "0",
        "4294967295",
        "18446744073709551615",
        "1e308",
        "nan",
        "99999999999999999999",
        "$Nodes\n",
        "<",
        "\0",
    ];
    for (name, bytes) in good_files() {
        for _ in 0..1_000 {
            let mut bytes = bytes.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(bytes.len());
                let word = words[random.below(words.len())].as_bytes();
                match random.below(4) {
                    0 => bytes[at] = random.next() as u8,
                    1 => bytes[at] ^= 1 << random.below(8),
                    2 => drop(bytes.splice(at..(at + random.below(9)).min(bytes.len()), word.iter().copied())),
                    _ => drop(bytes.drain(at..(at + random.below(30)).min(bytes.len() - 1))),
                }
            }
            if let Ok(mesh) = read_bytes(name, &bytes) {
                assert_eq!(mesh.check(), Ok(()), "{name}");
            }
        }
    }
}

#[test]
fn random_bytes_are_refused() {
    let mut random = SplitMix(1);
    for (name, good) in good_files() {
        for _ in 0..300 {
            let length = random.below(2_000);
            let noise: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
            assert!(read_bytes(name, &noise).is_err());
            // The head of a good file, then noise.
            let mut bytes = good[..random.below(good.len())].to_vec();
            bytes.extend(&noise);
            if let Ok(mesh) = read_bytes(name, &bytes) {
                assert_eq!(mesh.check(), Ok(()), "{name}");
            }
        }
    }
}

/// Counts of four billion in every header, and nesting without end: refused at once, without the memory they ask for.
#[test]
fn absurd_counts_are_refused() {
    let mut stl = binary_stl(b"");
    stl[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut msh = binary_msh(false);
    let block = msh.windows(7).position(|w| w == b"$Nodes\n").unwrap() + 7 + 32 + 12;
    msh[block..block + 8].copy_from_slice(&u64::MAX.to_le_bytes());
    let vtk = |from: &str, to: &str| VTK.replace(from, to).into_bytes();
    let files: Vec<(&str, Vec<u8>)> = vec![
        ("a.stl", stl),
        ("a.msh", msh),
        ("a.msh", MSH.replace("2 1 0 3\n", "2 1 0 4294967295\n").into_bytes()),
        ("a.msh", MSH.replace("2 4 7 12", "4294967295 0 18446744073709551615 18446744073709551615").into_bytes()),
        ("a.vtk", vtk("CELLS 3 11", "CELLS 4294967295 18446744073709551615")),
        ("a.vtk", vtk("CELL_TYPES 3", "CELL_TYPES 4294967295")),
        ("a.vtk", vtk("CELL_DATA 3", "CELL_DATA 18446744073709551615")),
        ("a.vtk", vtk("VECTORS fibre double", "FIELD f 4294967295\nfibre 18446744073709551615 18446744073709551615 double")),
        ("a.ply", PLY.replace("face 1", "face 18446744073709551615").into_bytes()),
        ("a.ply", PLY.replace("element face", "element nothing 4294967295\nelement face").into_bytes()),
        ("a.ply", PLY.replace("4 0 1 2 3", "4294967295 0 1 2 3").into_bytes()),
        ("a.ply", [b"ply\nformat binary_little_endian 1.0\nelement vertex 0\nelement void 4294967295\nelement face 0\nend_header\n", &[0u8; 90][..]].concat()),
        ("a.vtu", VTU.replace("Cells=\"2\"", "Cells=\"18446744073709551615\"").into_bytes()),
        ("a.vtu", "<a>".repeat(200_000).into_bytes()),
    ];
    for (name, bytes) in files {
        assert!(
            read_bytes(name, &bytes).is_err(),
            "{name}: {}",
            String::from_utf8_lossy(&bytes[..bytes.len().min(400)])
        );
    }
}
