//! Closed forms: what the rod must do where mathematics knows the answer.
//!
//! | file | load or motion | exact in |
//! |---|---|---|
//! | [`cantilever`] | tip load, tip moment, uniform load | small deflection |
//! | [`elastica`] | transverse tip load | any deflection |
//! | [`circle`] | tip moment | any deflection |
//! | [`tip_body_beam`] | free vibration with a rigid body at the tip | small deflection |
//! | [`pendulum`] | free swing of a rigid body | any swing |
//!
//! All are inextensible, planar and in W: clamp at the origin, x along the undeformed rod, z up,
//! angles from x towards z. A length, stiffness or mass that cannot be is a mistake of the caller:
//! these functions panic.

pub mod cantilever;
pub mod circle;
pub mod elastica;
pub mod elliptic;
pub mod pendulum;
pub mod tip_body_beam;

/// Where a point of a rod is, and which way the rod runs there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position in W, m.
    pub position: [f64; 2],
    /// Angle of the tangent, rad, from x towards z.
    pub angle: f64,
}
