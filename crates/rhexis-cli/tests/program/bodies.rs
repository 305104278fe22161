//! Invented bodies: a sheet with two V-shaped tears and a cap with a tear along a circle.

use glam::{DMat2, DMat3, DVec2, DVec3};
use rhexis::frame::{BodyFrame, TipFrame};
use std::f64::consts::{FRAC_PI_2, TAU};

pub struct Sheet {
    pub body: BodyFrame,
    /// Corners of the sheet.
    pub low: DVec2,
    pub high: DVec2,
    /// A point in an open tear.
    pub in_gap: DVec2,
    /// A point away from tears and tips.
    pub in_body: DVec2,
}

const FIBRE_ANGLE: f64 = 0.6;

/// The criterion's strength at an angle between direction and fibre: Allard et al. 2009, eq. 6 with α = ½.
fn strength(angle: f64, across: f64, along: f64) -> f64 {
    across + (along - across) * (angle / FRAC_PI_2).sqrt()
}

/// A tip whose curve belongs to a plane stress in the frame (x, y) of the surface.
fn tip(position: DVec3, frame: [DVec3; 2], stress: DMat2, fibre: f64, previous: f64, cone: f64) -> TipFrame {
    let space = |a: f64| frame[0] * a.cos() + frame[1] * a.sin();
    let curve: Vec<(DVec3, f64)> = (0..=120)
        .map(|k| previous + cone * (f64::from(k) / 60.0 - 1.0))
        .map(|a| {
            let normal = DVec2::from_angle(a).perp();
            let angle = (a - fibre).cos().abs().min(1.0).acos();
            (space(a), normal.dot(stress * normal) / strength(angle, 0.35, 1.1))
        })
        .collect();
    let (direction, value) = curve.iter().copied().fold((DVec3::X, 0.0), |a, b| if b.1 > a.1 { b } else { a });
    TipFrame {
        position,
        previous: Some(space(previous)),
        direction,
        value,
        curve,
        material_force: DVec3::ZERO,
        is_by_force: false,
        radius: 1.5,
    }
}

fn fill(body: &mut BodyFrame, field: impl Fn(DVec3) -> ([DVec3; 3], f64, f64, DVec3)) {
    for corners in &body.triangles {
        let middle = corners.iter().map(|&v| body.positions[v as usize]).sum::<DVec3>() / 3.0;
        let (axes, first, second, fibre) = field(middle);
        let axes = DMat3::from_cols(axes[0], axes[1], axes[2]);
        body.stress.push(axes * DMat3::from_diagonal(DVec3::new(first, second, 0.0)) * axes.transpose());
        body.principal_stress.push(DVec2::new(first, second));
        body.fibres.push(fibre);
        body.criterion.push(first / 0.35);
    }
}

/// 30 × 25 cells of 1 mm, torn from the middle of the top down and from the bottom up.
pub fn sheet() -> Sheet {
    let (nx, ny) = (30_u32, 25_u32);
    let tears = [(15_u32, 12.0, 1.0), (7, 6.0, -1.0)];
    let mut body = BodyFrame { name: "sheet".to_owned(), ..BodyFrame::default() };
    let index = |i: u32, j: u32| j * (nx + 1) + i;
    for j in 0..=ny {
        for i in 0..=nx {
            body.rest_positions.push(DVec3::new(f64::from(i), f64::from(j), 0.0));
        }
    }
    // The left copy of a torn vertex keeps its place in the arrays, the right one is new.
    let mut copies = std::collections::BTreeMap::new();
    for &(i, tip, side) in &tears {
        for j in (0..=ny).filter(|&j| (f64::from(j) - tip) * side > 0.0) {
            copies.insert((i, j), body.rest_positions.len() as u32);
            body.rest_positions.push(DVec3::new(f64::from(i), f64::from(j), 0.0));
        }
    }
    for j in 0..ny {
        for i in 0..nx {
            let left = |j: u32| copies.get(&(i, j)).copied().unwrap_or(index(i, j));
            let [a, b, c, d] = [left(j), index(i + 1, j), index(i + 1, j + 1), left(j + 1)];
            body.triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
    }
    // A tear opens with the square root of the distance to its tip, less towards the grips.
    let opening = |x: DVec3, i: f64, tip: f64, side: f64, is_right: bool| {
        let behind = ((x.y - tip) * side).max(0.0);
        let fade = if is_right { (30.0 - x.x) / (30.0 - i) } else { x.x / i };
        0.28 * behind.sqrt() * fade.clamp(0.0, 1.0) * if is_right { 1.0 } else { -1.0 }
    };
    let new: std::collections::BTreeSet<u32> = copies.values().copied().collect();
    body.positions = body
        .rest_positions
        .iter()
        .enumerate()
        .map(|(v, &x)| {
            let shift: f64 = tears
                .iter()
                .map(|&(i, tip, side)| {
                    let i = f64::from(i);
                    opening(x, i, tip, side, x.x > i || (x.x == i && new.contains(&(v as u32))))
                })
                .sum();
            x + DVec3::new(0.05 * (x.x - 15.0) + shift, 0.0, 0.0)
        })
        .collect();

    let ends = tears.map(|(i, y, side)| (DVec2::new(f64::from(i) * 1.05 - 0.75, y), side));
    let fibre = DVec3::new(FIBRE_ANGLE.cos(), FIBRE_ANGLE.sin(), 0.0);
    fill(&mut body, |x| {
        let mut size = 0.25 + 0.004 * x.y;
        for (end, side) in ends {
            let d = x.truncate() - end;
            let ahead = (-d.y * side / d.length() + 1.0) / 2.0;
            // Relieved beside the tear, raised before its tip.
            size += 0.55 * ahead / (d.length() + 0.3).sqrt() - 0.2 * (1.0 - ahead) * (-d.length() / 6.0).exp();
        }
        ([DVec3::X, DVec3::Y, DVec3::Z], size.max(0.01), 0.3 * size.min(0.5), fibre)
    });
    for (k, (end, side)) in ends.into_iter().enumerate() {
        let stress = DMat2::from_diagonal(DVec2::new(0.62 - 0.2 * k as f64, 0.2));
        body.tips.push(tip(end.extend(0.0), [DVec3::X, DVec3::Y], stress, FIBRE_ANGLE, -side * FRAC_PI_2, FRAC_PI_2));
    }
    Sheet {
        body,
        low: DVec2::new(-0.75, 0.0),
        high: DVec2::new(30.75, 25.0),
        in_gap: DVec2::new(15.0, 23.6),
        in_body: DVec2::new(26.3, 5.4),
    }
}

/// A cap of radius 10 mm, 9.8 mm across, torn along a circle of 5.2 mm, the inner part lifted beside the tear.
pub fn cap() -> BodyFrame {
    let (rings, sectors, torn_ring, torn_sectors) = (30_u32, 96_u32, 16_u32, 58_u32);
    let mut body = BodyFrame { name: "capsule".to_owned(), ..BodyFrame::default() };
    let on_cap = |r: f64, a: f64| DVec3::new(r * a.cos(), r * a.sin(), (100.0 - r * r).sqrt() - 10.0);
    let polar = |i: u32, k: u32| (4.9 * f64::from(i) / f64::from(rings), TAU * f64::from(k) / f64::from(sectors));
    let index = |i: u32, k: u32| if i == 0 { 0 } else { 1 + (i - 1) * sectors + k % sectors };
    body.rest_positions.push(DVec3::ZERO);
    for i in 1..=rings {
        for k in 0..sectors {
            let (r, a) = polar(i, k);
            body.rest_positions.push(on_cap(r, a));
        }
    }
    let first_copy = body.rest_positions.len() as u32;
    for k in 1..torn_sectors {
        body.rest_positions.push(body.rest_positions[index(torn_ring, k) as usize]);
    }
    let outer = |i: u32, k: u32| {
        let k = k % sectors;
        if i == torn_ring && (1..torn_sectors).contains(&k) { first_copy + k - 1 } else { index(i, k) }
    };
    for i in 0..rings {
        for k in 0..sectors {
            let lower = |k| if i >= torn_ring { outer(i, k) } else { index(i, k) };
            let [a, b, c, d] = [lower(k), index(i + 1, k), index(i + 1, k + 1), lower(k + 1)];
            if i > 0 {
                body.triangles.push([a, b, d]);
                body.triangles.push([b, c, d]);
            } else {
                body.triangles.push([a, b, c]);
            }
        }
    }
    let end = polar(torn_ring, torn_sectors);
    body.positions = body
        .rest_positions
        .iter()
        .enumerate()
        .map(|(v, &x)| {
            let (r, a) = (x.truncate().length(), x.y.atan2(x.x).rem_euclid(TAU));
            let along = (a / end.1).clamp(0.0, 1.0);
            let torn = (std::f64::consts::PI * along).sin() * if a < end.1 { 1.0 } else { 0.0 };
            let is_inner = (v as u32) < first_copy && r <= polar(torn_ring, 0).0 + 1e-9;
            if is_inner {
                let pull = torn * (r / 2.6).powi(2);
                x + DVec3::new(-0.55 * pull * a.cos(), -0.55 * pull * a.sin(), 0.5 * pull)
            } else {
                x + 0.08 * torn * (4.9 - r) / 2.3 * DVec3::new(a.cos(), a.sin(), 0.0)
            }
        })
        .collect();
    let place = on_cap(end.0, end.1);
    fill(&mut body, |x| {
        let a = x.y.atan2(x.x);
        let around = DVec3::new(-a.sin(), a.cos(), 0.0);
        let outward =
            (on_cap(x.truncate().length().min(4.9) + 1e-3, a) - on_cap(x.truncate().length().min(4.9), a)).normalize();
        let near = 1.0 / (x.distance(place) + 0.25).sqrt();
        let slack = if x.truncate().length() < 2.6 && a.rem_euclid(TAU) < end.1 { 0.25 } else { 1.0 };
        ([outward, around, outward.cross(around)], slack * (0.35 + 0.7 * near), 0.2, around)
    });
    let outward = (on_cap(end.0 + 1e-3, end.1) - place).normalize();
    let around = DVec3::new(-end.1.sin(), end.1.cos(), 0.0);
    let mut tip =
        tip(place, [outward, around], DMat2::from_diagonal(DVec2::new(0.52, 0.15)), FRAC_PI_2, FRAC_PI_2, 1.05);
    tip.radius = 0.25;
    body.tips.push(tip);
    body
}
