//! Energy release rate and stress intensities at a tip from the field in a ring around it. They are domain forms of the J-integral
//! (Li, Shih, Needleman 1985) and of the interaction integral (Yau, Wang, Corten 1980) with the fields of Sih, Paris and Irwin.
//!
//! Axes of the crack: 1 ahead, 2 across, the origin where the elements' field has its tip. The ring is laid out in the rest
//! shape and stays as it is until an edit touches its triangles; from step to step only the field in it changes. Displacements
//! are taken from the stress-free shape turned by the mean rotation of the ring: how the sheet lies in space does not matter.

use crate::components::RingFault;
use crate::math::{CrackTip, Orthotropic, Sym2, elementary};
use crate::storage::NONE;
use crate::systems::fracture::Surface;
use crate::systems::fracture::criterion::tip_disc::{TangentPlane, Walk};
use crate::systems::kernels::failure::TipField;
use crate::systems::kernels::membrane;
use crate::systems::kernels::polar::{self, stretches};
use crate::systems::kernels::simd::LANES;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The weight is 1 up to this part of the radius and falls to 0 at the radius. So the triangles at the tip, whose stress is the
/// worst, do not enter. Nor does the part of the lips between the field's tip and the vertex ahead of it. J over a ring of R
/// about the vertex met the loads of `tear-load` to 1.3 % and 5.2 % at four and two edges per R. Without the core it met them
/// to 2.2 % and 6.0 %.
const RING_CORE: f64 = 0.4;
/// Fewest edges to the radius: the core is then about one of them. With 2.8 the loads of `tear-load` are met to 1.6 %, with two
/// to 6.4 %.
const LEAST_RING_EDGES: f64 = 3.0;
/// cos 10°: normals farther off the ring's are those of a bent one. The field's error is of the order of the square, 3 %.
const COS_BENT: f64 = 0.984_807_753_012_208;
/// tan 20°: largest slope of a straight crack's lips outside the core, from the line behind the tip.
const TAN_STRAIGHT: f64 = 0.363_970_234_266_202_4;

/// The ring laid out on the surface.
#[derive(Clone, Debug, Default)]
pub struct Ring {
    members: Vec<Member>,
    /// All triangles on which it depends.
    triangles: Vec<u32>,
    /// Edges of the boundary in it, from the field's tip \[mm\].
    lips: Vec<[DVec2; 2]>,
    fault: Option<RingFault>,
    crack: Option<Crack>,
}

/// The crack that leads to the tip.
#[derive(Clone, Copy, Debug)]
struct Crack {
    /// Unit direction ahead in the axes in which the ring was laid.
    ahead: DVec2,
    fibre: DVec2,
    law: Orthotropic,
    tip: CrackTip,
}

/// A triangle of the ring. Vectors and tensors are in the axes of the crack.
#[derive(Clone, Copy, Debug)]
struct Member {
    triangle: u32,
    /// Unit direction.
    fibre: DVec2,
    /// Area \[mm²\].
    area: f64,
    /// Gradient of the weight \[1/mm\].
    fall: DVec2,
    /// Stress \[MPa\] and ∂₁u of the fields of K_I = 1 and K_II = 1 at the centroid.
    modes: [(Sym2, DVec2); 2],
}

/// Results of the contour integrals over a ring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contour {
    /// The field at the tip, in the axes in which the ring was laid.
    pub field: TipField,
    /// J \[N/mm\]: energy released per area of a crack that goes straight on.
    pub release: f64,
}

impl Ring {
    /// Lays the ring of `radius` \[mm\] about `centre` (rest shape), whose tangent plane has the orthonormal `axes` and
    /// the `fibre`, starting from the triangles `start`, which are those at the tip.
    pub fn lay(
        &mut self,
        surface: &Surface,
        (centre, axes, radius): (DVec3, [DVec3; 2], f64),
        fibre: DVec2,
        start: impl IntoIterator<Item = u32>,
        walk: &mut Walk,
    ) {
        let Surface { vertices, triangles, topology, .. } = *surface;
        let plane = TangentPlane::new(centre, axes);
        (self.crack, self.fault) = (None, None);
        self.members.clear();
        self.triangles.clear();
        self.lips.clear();
        walk.begin(triangles.len());
        start.into_iter().for_each(|t| walk.visit(t));
        let (mut next, mut area, mut count) = (0, 0.0, 0.0);
        while let Some(triangle) = walk.at(next) {
            next += 1;
            self.triangles.push(triangle);
            let t = triangle as usize;
            let x = triangles.corners[t].map(|v| vertices.rest_position[v as usize]);
            let (placed, is_flat) = plane.place(x);
            let distance = placed.map(DVec2::length);
            if distance.into_iter().all(|r| r >= radius) {
                continue;
            }
            let normal = (x[1] - x[0]).cross(x[2] - x[0]);
            if normal.dot(plane.normal) < COS_BENT * normal.length() {
                self.fault = Some(RingFault::Bent);
            }
            area += triangles.rest[t].area;
            count += 1.0;
            for edge in 0..3 {
                let neighbour = topology.neighbours[t][edge];
                if neighbour == NONE {
                    self.lips.push([placed[edge], placed[(edge + 1) % 3]]);
                } else {
                    walk.visit(neighbour);
                }
            }
            let weight = distance.map(|r| ((1.0 - r / radius) / (1.0 - RING_CORE)).clamp(0.0, 1.0));
            if weight != [1.0; 3] {
                let fibre = plane.direction(triangles.fibre[t], x, is_flat);
                let own = triangles.rest[t].all_gradients();
                let fall: DVec2 = own.into_iter().zip(weight).map(|(gradient, weight)| gradient * weight).sum();
                let middle = (placed[0] + placed[1] + placed[2]) / 3.0;
                // In the axes of the layout first; the place stands in for the fields until the crack's direction is known.
                let modes = [(Sym2::ZERO, middle), (Sym2::ZERO, middle)];
                self.members.push(Member {
                    triangle,
                    fibre,
                    area: triangles.rest[t].area,
                    fall: fibre.rotate(fall),
                    modes,
                });
            }
        }
        let edge = crate::systems::fracture::size(area / count);
        if !(radius >= LEAST_RING_EDGES * edge) {
            self.fault.get_or_insert(RingFault::Coarse);
        }
        let law = self.triangles.first().and_then(|&t| triangles.stiffness.get(t as usize));
        match (self.direction(radius), law) {
            (Err(fault), _) => self.fault = self.fault.or(Some(fault)),
            (Ok(ahead), Some(&law)) if self.fault.is_none() => {
                let tip = CrackTip::new(&law, elementary::turn(ahead, fibre));
                self.crack = Some(Crack { ahead, fibre, law, tip });
                self.members.iter_mut().for_each(|member| member.turn(ahead, &tip));
            }
            _ => {}
        }
    }

    /// The direction of the crack: away from where its lips lie between core and radius.
    fn direction(&self, radius: f64) -> Result<DVec2, RingFault> {
        let core = RING_CORE * radius;
        let outside = || self.lips.iter().filter(|lip| lip.iter().any(|end| end.length() > core));
        let behind: DVec2 = outside().map(|[a, b]| (*a + *b).normalize_or_zero() * a.distance(*b)).sum();
        let behind = behind.try_normalize().ok_or(RingFault::NoCrack)?;
        let is_straight = |p: &DVec2| p.length() <= core || p.perp_dot(behind).abs() <= TAN_STRAIGHT * p.dot(behind);
        if !outside().flatten().all(is_straight) {
            return Err(RingFault::OtherBoundary);
        }
        let leaves = |lip: &&[DVec2; 2]| (lip[0].length() < radius) != (lip[1].length() < radius);
        match self.lips.iter().filter(leaves).count() {
            2 => Ok(-behind),
            0 => Err(RingFault::NoCrack),
            _ => Err(RingFault::OtherBoundary),
        }
    }

    /// The triangles on which the ring depends.
    pub fn triangles(&self) -> impl Iterator<Item = u32> {
        self.triangles.iter().copied()
    }

    /// The integrals at the current positions.
    ///
    /// # Errors
    /// Where the ring does not have the field of one straight crack.
    pub fn contour(&self, surface: &Surface) -> Result<Contour, RingFault> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        if surface.fibres.is_some() {
            return Err(RingFault::Stiffening);
        }
        let Crack { ahead, fibre, law, tip } = self.crack.ok_or(RingFault::NoCrack)?;
        let Surface { triangles, is_planar, unstretched, .. } = *surface;
        let (mut area, mut mean) = (0.0, [DVec3::ZERO; 2]);
        for member in &self.members {
            let f = member.in_crack_axes(member.gradient(surface));
            mean = [mean[0] + f[0] * member.area, mean[1] + f[1] * member.area];
            area += member.area;
        }
        let [mean1, mean2] = mean.map(|f| f / area);
        let turned = if is_planar { polar::planar(mean1, mean2) } else { polar::membrane(mean1, mean2) };
        let (r1, r2) = (turned.fibre_axis, turned.transverse_axis);
        let normal = r1.cross(r2);
        let (mut release, mut interaction) = (0.0, [0.0; 2]);
        for members in self.members.chunks(LANES) {
            let mut gradients = [(DVec3::X, DVec3::Y); LANES];
            gradients.iter_mut().zip(members).for_each(|(f, member)| *f = member.gradient(surface));
            for ((member, u), (f1, f2)) in members.iter().zip(stretches(&gradients, is_planar)).zip(gradients) {
                let cross = f1.cross(f2);
                if !is_planar && cross.dot(normal) < COS_BENT * cross.length() {
                    return Err(RingFault::Bent);
                }
                let unstretched = triangles.unstretched(member.triangle as usize, unstretched);
                let strain = u - unstretched;
                let stress = member.turned(triangles.stiffness[member.triangle as usize].stress(strain));
                let free = member.turned(unstretched);
                let (strain, [along, _]) = (member.turned(strain), member.in_crack_axes((f1, f2)));
                let slope = DVec2::new(r1.dot(along) - free.xx, r2.dot(along) - free.xy);
                // (σ·∂₁u − W·e₁)·∇q, and its mixed terms with the fields of each mode.
                let (fall, volume) = (member.fall, member.area);
                release += volume * (stress.apply(slope).dot(fall) - 0.5 * stress.contract(strain) * fall.x);
                for (sum, (mode_stress, mode_slope)) in interaction.iter_mut().zip(member.modes) {
                    let mixed = stress.apply(mode_slope).dot(fall) + mode_stress.apply(slope).dot(fall);
                    *sum += volume * (mixed - mode_stress.contract(strain) * fall.x);
                }
            }
        }
        let intensities = tip.intensities(interaction);
        let is_finite = release.is_finite() && intensities.iter().all(|k| k.is_finite());
        let field = TipField { law, fibre, ahead, intensities };
        is_finite.then_some(Contour { field, release }).ok_or(RingFault::NoRelease)
    }
}

impl Member {
    /// From the axes of the layout into those of the crack, with the fields of its modes.
    fn turn(&mut self, ahead: DVec2, tip: &CrackTip) {
        let into = |v: DVec2| DVec2::new(v.dot(ahead), ahead.perp_dot(v));
        let place = into(self.modes[0].1);
        let (r, theta) = (place.length(), elementary::angle_of(place));
        let scale = 1.0 / (TAU * r).sqrt();
        let (stress, slope) = (tip.stress(theta), tip.slope(theta));
        self.modes = [(stress.opening * scale, slope.opening * scale), (stress.sliding * scale, slope.sliding * scale)];
        (self.fibre, self.fall) = (into(self.fibre), into(self.fall));
    }

    /// Columns of the deformation gradient in the triangle's own frame.
    fn gradient(&self, surface: &Surface) -> (DVec3, DVec3) {
        let t = self.triangle as usize;
        let x = surface.triangles.corners[t].map(|v| surface.vertices.position[v as usize]);
        membrane::gradient(x, &surface.triangles.rest[t])
    }

    /// Columns of the deformation gradient along the axes of the crack.
    fn in_crack_axes(&self, (f1, f2): (DVec3, DVec3)) -> [DVec3; 2] {
        let DVec2 { x: c, y: s } = self.fibre;
        [f1 * c - f2 * s, f1 * s + f2 * c]
    }

    /// A tensor of the triangle's own frame in the axes of the crack.
    fn turned(&self, tensor: Sym2) -> Sym2 {
        let DVec2 { x: c, y: s } = self.fibre;
        tensor.in_axes(DVec2::new(c, -s), DVec2::new(s, c))
    }
}
