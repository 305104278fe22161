//! The geometry of tears: straight, wandering, cut and started inside.

mod meshes;

use glam::DVec3;
use meshes::{Body, Random};
use rhexis::storage::measure::{rest_angles, total_area, total_mass};
use rhexis::systems::tearing::{Cutter, Quality, TearRefusal, TearScratch};

fn everything(_: u32) -> bool {
    true
}

fn cutter<'c, 'm>(mesh: &'c mut rhexis::storage::Mesh<'m>, scratch: &'c mut TearScratch) -> Cutter<'c, 'm> {
    Cutter { mesh, is_movable: &everything, quality: Quality::default(), scratch }
}

#[derive(Default, Debug)]
struct Statistics {
    advances: usize,
    snaps: usize,
    refused: usize,
    ended: usize,
    freed: usize,
    length: f64,
    triangles_added: usize,
}

fn angles(body: &Body) -> (f64, f64) {
    let mut all: Vec<f64> = rest_angles(&body.vertices, &body.triangles).map(f64::to_degrees).collect();
    all.sort_by(f64::total_cmp);
    (all[0], all[all.len() / 100])
}

#[test]
fn wandering_tears() {
    for (name, sheet, edge) in [
        ("grid", meshes::grid(30, 26, 30.0, 30.0), 1.1),
        ("jittered", meshes::jittered(30, 26, 30.0, 30.0, 5), 1.1),
        ("cap", meshes::cap(14), 0.37),
    ] {
        let mut worst: f64 = 90.0;
        let mut stats = Statistics::default();
        let mut percentile: f64 = 90.0;
        let mut touched = Vec::new();
        let start = angles(&Body::new(&sheet, DVec3::X));
        for seed in 0..20 {
            let mut random = Random::new(seed);
            let mut body = Body::new(&sheet, DVec3::X);
            let before = body.triangles.len();
            let mut scratch = TearScratch::default();
            for _ in 0..4 {
                let boundary: Vec<u32> =
                    (0..body.vertices.len() as u32).filter(|&v| body.topology.is_boundary_vertex(v)).collect();
                let mut tip = boundary[random.below(boundary.len())];
                let mut direction = -body.vertices.rest_position[tip as usize];
                if name != "cap" {
                    direction += DVec3::new(15.0, 15.0, 0.0);
                }
                for _ in 0..200 {
                    let mut mesh = body.mesh();
                    match cutter(&mut mesh, &mut scratch).advance(tip, direction, f64::INFINITY) {
                        Ok(advance) => {
                            stats.advances += 1;
                            stats.snaps += usize::from(advance.deviation > 0.0);
                            stats.length += advance.length() / edge;
                            touched.push(advance.smallest_angle.to_degrees());
                            if let Some(end) = advance.end {
                                stats.ended += 1;
                                stats.freed += usize::from(end.freed.is_some());
                                break;
                            }
                            tip = advance.vertex;
                            let ahead = advance.to - advance.from;
                            let turn = random.between(-0.5, 0.5);
                            let normal = if name == "cap" { advance.to.normalize() } else { DVec3::Z };
                            direction = glam::DQuat::from_axis_angle(normal, turn) * ahead;
                        }
                        Err(refusal) => {
                            stats.refused += 1;
                            println!("{name} {seed}: {refusal}");
                            break;
                        }
                    }
                }
            }
            assert_eq!(body.mesh().validate(), Ok(()));
            stats.triangles_added += body.triangles.len() - before;
            let (least, first) = angles(&body);
            worst = worst.min(least);
            percentile = percentile.min(first);
        }
        touched.sort_by(f64::total_cmp);
        println!(
            "{name}: start {start:.1?} worst {worst:.2} p1 {percentile:.2} per edge {:.2} touched {:.1} {:.1} {:.1} {stats:?}",
            stats.triangles_added as f64 / stats.length,
            touched[touched.len() / 100],
            touched[touched.len() / 10],
            touched[touched.len() / 2],
        );
    }
}
