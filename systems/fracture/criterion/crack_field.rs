//! The field of a plane crack around a tip: intensities K_I, K_II by the interaction integral (Yau, Wang, Corten 1980) in its domain form (Li,
//! Shih, Needleman 1985), with the fields of Sih, Paris and Irwin, over the disc of the material force.
//!
//! Disc and present surface are unfolded into planes: every triangle is turned into the plane of the mean normal by the smallest rotation.
//! Displacements are taken from the stress-free shape turned by the mean rotation within that plane. So neither place nor bend of the
//! sheet matters. The intensities give the share of a kink; the amount of energy is the material force's.

use crate::components::RingFault;
use crate::math::{CrackTip, Orthotropic, Sym2, elementary};
use crate::systems::fracture::Surface;
use crate::systems::fracture::criterion::tip_disc::TangentPlane;
use crate::systems::kernels::failure::TipField;
use crate::systems::kernels::material_force::Unfolding;
use crate::systems::kernels::polar;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// cos 60°: a normal farther off the mean belongs to a fold, across which the sheet is no plane.
const COS_FOLDED: f64 = 0.5;
/// tan 20°: largest slope of a straight crack's lips outside the core, from the line behind the tip.
const TAN_STRAIGHT: f64 = 0.363_970_234_266_202_4;

/// Directions in which a disc's crack is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrackFrame {
    /// Unit mean fibre at the tip.
    pub fibre: DVec2,
    /// Place of the field's tip from the vertex \[mm\].
    pub tip: DVec2,
}

/// The crack that leads to a tip, and the fields of its modes in the disc.
#[derive(Clone, Debug, Default)]
pub(super) struct CrackField {
    fault: Option<RingFault>,
    frame: Option<CrackFrame>,
    crack: Option<Crack>,
    members: Vec<Member>,
    /// Whether the members have the fields of the modes.
    has_modes: bool,
    states: Vec<MemberState>,
    /// Area times unit normal of the present surface \[mm²\].
    normal: DVec3,
}

#[derive(Clone, Copy, Debug)]
struct Crack {
    /// Unit direction ahead in the axes of the disc.
    ahead: DVec2,
    law: Orthotropic,
    tip: CrackTip,
}

/// A triangle on which the weight falls, in the axes of the disc.
#[derive(Clone, Copy, Debug)]
struct Member {
    /// Centroid from the field's tip \[mm\].
    middle: DVec2,
    /// Area \[mm²\].
    area: f64,
    /// Gradient of the weight \[1/mm\].
    fall: DVec2,
    /// Stress \[MPa\] and change of the displacement along the crack of the fields of K_I = 1 and K_II = 1 at the centroid.
    modes: [(Sym2, DVec2); 2],
}

/// The present state of a triangle, in the axes of the disc.
#[derive(Clone, Copy, Debug)]
pub(super) struct MemberState {
    /// Columns of the deformation gradient.
    pub gradient: [DVec3; 2],
    /// Biot stress \[MPa\].
    pub stress: Sym2,
    /// Stretch, and stretch that is free of stress.
    pub stretch: [Sym2; 2],
}

impl CrackField {
    pub(super) fn make_room(&mut self, count: usize) {
        self.members.reserve(count);
        self.states.reserve(count);
    }

    pub(super) fn clear(&mut self, frame: CrackFrame) {
        (self.frame, self.fault, self.crack, self.has_modes) = (Some(frame), None, None, false);
        self.members.clear();
    }

    /// Directions for which the field was laid.
    pub(super) fn frame(&self) -> Option<CrackFrame> {
        self.frame
    }

    /// Adds a triangle of the disc with its corners in the plane of this normal, and the gradient of its weight \[1/mm\].
    pub(super) fn add(&mut self, corners: [DVec3; 3], (plane, area, fall): (&TangentPlane, f64, DVec2)) {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        if normal.dot(plane.normal) < COS_FOLDED * normal.length() {
            self.fault = Some(RingFault::Bent);
        }
        let [a, b, c] = plane.place(corners).0;
        let tip = self.frame.map_or(DVec2::ZERO, |frame| frame.tip);
        self.members.push(Member {
            middle: (a + b + c) / 3.0 - tip,
            area,
            fall,
            modes: [(Sym2::ZERO, DVec2::ZERO); 2],
        });
    }

    /// Finds the crack of a disc whose weight is 1 within `core` and 0 from `radius` on \[mm\], from the boundary edges in it.
    pub(super) fn find_crack(
        &mut self,
        law: Option<&Orthotropic>,
        (core, radius): (f64, f64),
        lips: impl Iterator<Item = [DVec2; 2]> + Clone,
    ) {
        match (direction(lips, core, radius), law, self.frame) {
            (Ok(ahead), Some(&law), Some(frame)) => {
                let tip = CrackTip::new(&law, elementary::turn(ahead, frame.fibre));
                self.crack = Some(Crack { ahead, law, tip });
            }
            (found, ..) => self.fault = self.fault.or(Some(found.err().unwrap_or(RingFault::NoCrack))),
        }
    }

    /// Begins a reading; `false` where the disc has no crack that could be read.
    pub(super) fn begin(&mut self) -> bool {
        self.states.clear();
        self.normal = DVec3::ZERO;
        self.fault.is_none() && self.crack.is_some()
    }

    /// Adds the state of the next triangle.
    pub(super) fn push(&mut self, state: MemberState) {
        let area = self.members.get(self.states.len()).map_or(0.0, |member| member.area);
        self.normal += unit_normal(&state) * area;
        self.states.push(state);
    }

    /// The field at the tip, from the states of all triangles.
    ///
    /// # Errors
    /// Where the disc does not have the field of one straight crack.
    pub(super) fn read(&mut self, surface: &Surface) -> Result<TipField, RingFault> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        if surface.fibres.is_some() {
            return Err(RingFault::Stiffening);
        }
        let (Some(Crack { ahead, law, tip }), Some(frame)) = (self.crack, self.frame) else {
            return Err(RingFault::NoCrack);
        };
        let normal = self.normal.normalize_or(DVec3::Z);
        let (mut mean, mut area) = ([DVec3::ZERO; 2], 0.0);
        for (state, member) in self.states.iter_mut().zip(&self.members) {
            let own = unit_normal(state);
            let cos = own.dot(normal);
            if !(cos >= COS_FOLDED) {
                return Err(RingFault::Bent);
            }
            let unfolded = Unfolding::between(own, normal);
            state.gradient = state.gradient.map(|column| unfolded.apply(column));
            mean = [0, 1].map(|i| mean[i] + state.gradient[i] * member.area);
            area += member.area;
        }
        let [mean1, mean2] = mean.map(|column| column / area);
        let turned = if surface.is_planar { polar::planar(mean1, mean2) } else { polar::membrane(mean1, mean2) };
        let (r1, r2) = (turned.fibre_axis, turned.transverse_axis);
        if !self.has_modes {
            self.members.iter_mut().for_each(|member| member.modes = modes(&tip, ahead, member.middle));
            self.has_modes = true;
        }
        let mut interaction = [0.0; 2];
        for (&MemberState { gradient: [f1, f2], stress, stretch: [stretch, free] }, member) in
            self.states.iter().zip(&self.members)
        {
            let along = f1 * ahead.x + f2 * ahead.y;
            let slope = DVec2::new(r1.dot(along), r2.dot(along)) - free.apply(ahead);
            let (strain, fall) = (stretch - free, member.fall);
            // Mixed terms of (σ·∂u − W·a)·∇q, ∂ the derivative along the crack's direction a.
            for (sum, (mode_stress, mode_slope)) in interaction.iter_mut().zip(member.modes) {
                let mixed = stress.apply(mode_slope).dot(fall) + mode_stress.apply(slope).dot(fall);
                *sum += member.area * (mixed - mode_stress.contract(strain) * ahead.dot(fall));
            }
        }
        let intensities = tip.intensities(interaction);
        let field = TipField { law, fibre: frame.fibre, ahead, intensities };
        intensities.iter().all(|k| k.is_finite()).then_some(field).ok_or(RingFault::NoRelease)
    }
}

/// The direction of the crack: away from where its lips lie between core and radius.
fn direction(lips: impl Iterator<Item = [DVec2; 2]> + Clone, core: f64, radius: f64) -> Result<DVec2, RingFault> {
    let outside = || lips.clone().filter(|lip| lip.iter().any(|end| end.length() > core));
    let behind: DVec2 = outside().map(|[a, b]| (a + b).normalize_or_zero() * a.distance(b)).sum();
    let behind = behind.try_normalize().ok_or(RingFault::NoCrack)?;
    let is_straight = |p: DVec2| p.length() <= core || p.perp_dot(behind).abs() <= TAN_STRAIGHT * p.dot(behind);
    if !outside().flatten().all(is_straight) {
        return Err(RingFault::OtherBoundary);
    }
    let leaves = |lip: &[DVec2; 2]| (lip[0].length() < radius) != (lip[1].length() < radius);
    match lips.clone().filter(leaves).count() {
        2 => Ok(-behind),
        0 => Err(RingFault::NoCrack),
        _ => Err(RingFault::OtherBoundary),
    }
}

/// The fields of K_I = 1 and K_II = 1 at a place from the tip \[mm\], in the axes in which that and the crack's direction are.
fn modes(tip: &CrackTip, ahead: DVec2, place: DVec2) -> [(Sym2, DVec2); 2] {
    let (r, theta) = (place.length(), elementary::turn(ahead, place));
    let scale = 1.0 / (TAU * r).sqrt();
    let (stress, slope) = (tip.stress(theta), tip.slope(theta));
    let turned = |stress: Sym2, slope: DVec2| {
        let stress = stress.in_axes(DVec2::new(ahead.x, -ahead.y), DVec2::new(ahead.y, ahead.x));
        (stress * scale, ahead.rotate(slope) * scale)
    };
    [turned(stress.opening, slope.opening), turned(stress.sliding, slope.sliding)]
}

fn unit_normal(state: &MemberState) -> DVec3 {
    state.gradient[0].cross(state.gradient[1]).normalize_or_zero()
}
