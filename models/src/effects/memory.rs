//! Laws of memory that several effects have in common, and scale each in its own way.

use super::{Bend, Moment, Parameter, Per, Real};

/// Curvature over which friction turns round, 1/m: 0.1 mm at the tip of a muscle of 0.2 m.
pub(super) const BRISTLE: f64 = 0.01;

/// Rate below which what sticks creeps.
pub(super) const CREEP_RATE: Parameter = Parameter {
    name: "creep_rate",
    meaning: "rate of curvature below which what sticks creeps",
    unit: "1/(m s)",
    default: 0.02,
    range: (1e-6, 1e3),
    scale: 0.02,
    plausible: Some((1e-3, 1.0)),
    tries: &[0.002, 0.02, 0.2],
    ..Parameter::PLAIN
};

/// Moment at which a cross-section slides.
pub(super) const FRICTION_MOMENT: Parameter = Parameter {
    name: "friction_moment",
    meaning: "moment at which a cross-section slides",
    unit: "N m",
    default: 5e-4,
    range: (0.0, 100.0),
    scale: 5e-4,
    null_value: Some(0.0),
    is_friction: true,
    plausible: Some((0.0, 0.1)),
    per: Per::WeightMoment,
    ..Parameter::PLAIN
};

/// Friction of a moment at which a section slides, N m: `M = M_f z`, `ż = (κ̇ − z √(κ̇² + κ̇₀²)) / κ_b`. The
/// share z, between −1 and 1, builds up over the curvature `bristle`, 1/m; the step M_f sgn κ̇ itself changes
/// its slope faster than an integrator can follow.
pub(super) fn friction<T: Real>(at: &Bend<T>, sliding: T, creep_rate: T, bristle: T) -> Moment<T> {
    let rate = (at.kappa_rate * at.kappa_rate + creep_rate * creep_rate).sqrt();
    Moment { moment: sliding * at.memory, memory_rate: (at.kappa_rate - at.memory * rate) / bristle }
}

/// Energy in bent bristles, J per metre of rod.
pub(super) fn friction_energy<T: Real>(at: &Bend<T>, sliding: T, bristle: T) -> T {
    sliding * bristle * at.memory * at.memory * 0.5
}

/// A spring and a dashpot in series: `M = g EI (κ − z)`, `ż = (κ − z) / τ`; g is `share`, τ the `time` in s.
pub(super) fn maxwell<T: Real>(at: &Bend<T>, share: T, time: T) -> Moment<T> {
    let strain = at.kappa - at.memory;
    Moment { moment: share * at.rod.bending_stiffness * strain, memory_rate: strain / time }
}

/// Energy in that spring, J per metre of rod.
pub(super) fn maxwell_energy<T: Real>(at: &Bend<T>, share: T) -> T {
    let strain = at.kappa - at.memory;
    share * at.rod.bending_stiffness * strain * strain * 0.5
}
