//! A rod that is held at its end: by a string, which pulls, or by a hand, which turns it as well.
//!
//! The load with which it is held is dead: a force at right angles to the clamp, and a moment if it is turned, on the end
//! of the active length. At a level clamp the force is vertical, as a string is in a laboratory; a vertical one would only
//! stretch a rod that hangs. Newton's method on the hold's targets finds the load; each step finds a rest. The targets move from
//! the free rest to where it is wanted, in steps as large as Newton's method can follow.

use nalgebra::{DMatrix, DVector};

use super::equilibrium;
use crate::error::ModelError;
use crate::model::Model;
use crate::system::System;

/// How the end of the active length is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold {
    /// Direction from the clamp in which it is held, rad above the horizontal, by a force at right angles to the clamp.
    pub direction: f64,
    /// Angle at which the end body is held, rad from x towards z; none for a string, which lets it turn.
    pub end_angle: Option<f64>,
}

/// The effect by which a model is held.
const LOAD: &str = "tip_load";
const PATHS: [&str; 3] = ["effects.tip_load.force_x", "effects.tip_load.force_z", "effects.tip_load.moment"];
/// What is left of directions and angles, rad.
const TOLERANCE: f64 = 1e-9;
const MOST_ITERATIONS: usize = 20;
/// Share of the way below which there is none.
const SMALLEST_STEP: f64 = 1.0 / 1024.0;

/// The model with the load that holds it, beside what tip load it has, and the places of that load in `theta`.
/// # Errors
/// [`ModelError::Held`] where no load is found, such as for a direction that the rod cannot take.
pub fn held(model: &Model, hold: &Hold) -> Result<(Model, Vec<usize>), ModelError> {
    let mut search = Search::new(model, hold)?;
    let free = search.rest(&DVector::zeros(search.unknowns()), None)?;
    let mut at = (DVector::zeros(search.unknowns()), free.q.clone());
    let (mut share, mut step): (f64, f64) = (0.0, 0.5);
    while share < 1.0 {
        let next = (share + step).min(1.0);
        match search.follow(&at, &free.asked, next) {
            Some(found) => {
                (share, at) = (next, found);
                step *= 2.0;
            }
            None if step > SMALLEST_STEP => step *= 0.5,
            None => return Err(ModelError::Held { reached_percent: 100.0 * share }),
        }
    }
    search.load(&at.0);
    Ok((search.model, search.places))
}

/// A rest under a load.
struct Rest {
    q: Vec<f64>,
    /// Deviation from the hold's targets: the end's direction, and its angle.
    asked: DVector<f64>,
}

struct Search<'h> {
    model: Model,
    hold: &'h Hold,
    places: Vec<usize>,
    /// Place of the angle of the clamp.
    base_angle: usize,
    before: Vec<f64>,
    /// Size of a force that bends the rod, N.
    force: f64,
}

impl<'h> Search<'h> {
    fn new(model: &Model, hold: &'h Hold) -> Result<Self, ModelError> {
        let mut model =
            if model.effect(LOAD).is_some() { model.clone() } else { model.with_effect(LOAD, &[])? };
        model.schedule = None;
        let places = PATHS.iter().map(|path| model.index(path)).collect::<Result<Vec<_>, _>>()?;
        let base_angle = model.index("rod.base_angle")?;
        let before = places.iter().map(|k| model.theta[*k]).collect();
        let rod = model.rod();
        Ok(Self {
            hold,
            places,
            base_angle,
            before,
            force: rod.bending_stiffness / rod.length.powi(2) + 1e-3,
            model,
        })
    }

    fn unknowns(&self) -> usize {
        1 + usize::from(self.hold.end_angle.is_some())
    }

    /// Puts a load, over the size of a force and over that times the rod's length, into the model.
    fn load(&mut self, load: &DVector<f64>) {
        let (sin, cos) = self.model.theta[self.base_angle].sin_cos();
        let moment = load.get(1).copied().unwrap_or(0.0) * self.model.rod().length;
        let values = [-sin * load[0], cos * load[0], moment];
        for ((place, before), value) in self.places.iter().zip(&self.before).zip(values) {
            self.model.theta[*place] = before + self.force * value;
        }
    }

    fn rest(&mut self, load: &DVector<f64>, start: Option<&[f64]>) -> Result<Rest, ModelError> {
        self.load(load);
        let q = equilibrium(&self.model, start)?.q;
        let mut system = System::new(&self.model);
        let end = system.assembly.posture(&q, &vec![0.0; q.len()]);
        let [x, z] = end.nodes[self.model.edges];
        // Angles are counted from the target, so that straight up and down are nothing special.
        let (sin, cos) = self.hold.direction.sin_cos();
        let mut asked = vec![f64::atan2(cos * z - sin * x, cos * x + sin * z)];
        asked.extend(self.hold.end_angle.map(|angle| end.angle - angle));
        Ok(Rest { q, asked: DVector::from_vec(asked) })
    }

    /// The load with which a share of the way from the free rest is held, from one that holds less of it.
    fn follow(
        &mut self,
        at: &(DVector<f64>, Vec<f64>),
        free: &DVector<f64>,
        share: f64,
    ) -> Option<(DVector<f64>, Vec<f64>)> {
        let wanted = free * (1.0 - share);
        let (mut load, mut q) = at.clone();
        let mut last = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            let rest = self.rest(&load, Some(&q)).ok()?;
            let off = &rest.asked - &wanted;
            q = rest.q;
            if off.amax() < TOLERANCE {
                return Some((load, q));
            }
            if off.amax() > last {
                return None;
            }
            last = off.amax();
            let mut slopes = DMatrix::zeros(load.len(), load.len());
            for k in 0..load.len() {
                let mut moved = load.clone();
                moved[k] += 1e-5;
                let change = (self.rest(&moved, Some(&q)).ok()?.asked - &rest.asked) / 1e-5;
                slopes.set_column(k, &change);
            }
            load -= slopes.lu().solve(&off)?;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::tests::rod_with;

    const LIGHT: (&str, &[(&str, f64)]) = ("gravity", &[("acceleration", 0.0)]);

    fn end(model: &Model) -> ([f64; 2], f64) {
        let q = equilibrium(model, None).unwrap().q;
        let posture = System::new(model).assembly.posture(&q, &vec![0.0; q.len()]);
        (posture.nodes[model.edges], posture.angle)
    }

    /// Of small bending the load is that of a beam: `3 EI w / L³` for a string that moves the end by `w`, and with
    /// the end's angle held `6 EI (2 w − L θ) / L³` and `2 EI (2 L θ − 3 w) / L²`.
    #[test]
    fn small_holds_take_the_load_of_a_beam() {
        let mut model = rod_with(&[LIGHT]);
        model.set("rod.base_angle", 0.0).unwrap();
        let rod = model.rod();
        let (length, stiffness) = (rod.length, rod.bending_stiffness);
        let angle: f64 = 1e-3;
        let (string, places) = held(&model, &Hold { direction: angle, end_angle: None }).unwrap();
        let due = 3.0 * stiffness * angle / length.powi(2);
        let found = string.theta[places[1]];
        assert!((found / due - 1.0).abs() < 1e-4, "{found} N, due {due} N");
        let turned = 2e-3;
        let (hand, places) = held(&model, &Hold { direction: angle, end_angle: Some(turned) }).unwrap();
        let force = 6.0 * stiffness * (2.0 * angle - turned) / length.powi(2);
        let moment = 2.0 * stiffness * (2.0 * turned - 3.0 * angle) / length;
        let found = [hand.theta[places[1]], hand.theta[places[2]]];
        assert!((found[0] - force).abs() < 1e-4 * moment.abs() / length, "{found:?}, due {force} N");
        assert!((found[1] / moment - 1.0).abs() < 1e-4, "{found:?}, due {moment} N m");
    }

    #[test]
    fn the_end_is_where_it_is_held() {
        let model = rod_with(&[("end_fitting", &[("mass", 0.05), ("center_of_mass", 0.017)])]);
        for degrees in [-80.0_f64, -20.0, 30.0, 70.0] {
            let angle = degrees.to_radians();
            let (string, _) = held(&model, &Hold { direction: angle, end_angle: None }).unwrap();
            let ([x, z], _) = end(&string);
            assert!((z.atan2(x) - angle).abs() < 1e-8, "{degrees}: {}", z.atan2(x).to_degrees());
            let (hand, _) = held(&model, &Hold { direction: angle, end_angle: Some(angle) }).unwrap();
            let ([x, z], turned) = end(&hand);
            assert!(
                (z.atan2(x) - angle).abs() < 1e-8 && (turned - angle).abs() < 1e-8,
                "{degrees}: {turned}"
            );
        }
    }

    /// However steep the clamp: a rod that hangs is pulled aside by the force of a beam, which holds a small angle with
    /// `3 EI θ / L²`. A vertical force found none at -90 degrees.
    #[test]
    fn a_rod_that_hangs_is_pulled_aside() {
        let mut model = rod_with(&[LIGHT]);
        let rod = model.rod();
        for degrees in [-90.0_f64, -89.99, -90.0 + 1e-9, 90.0, 180.0, -60.0] {
            let base = degrees.to_radians();
            model.set("rod.base_angle", base).unwrap();
            let aside = 1e-3;
            let (string, places) = held(&model, &Hold { direction: base + aside, end_angle: None }).unwrap();
            let force = [string.theta[places[0]], string.theta[places[1]]];
            let due = 3.0 * rod.bending_stiffness * aside / rod.length.powi(2);
            let along = force[0] * base.cos() + force[1] * base.sin();
            let across = force[1] * base.cos() - force[0] * base.sin();
            assert!((across / due - 1.0).abs() < 1e-4 && along.abs() < 2e-3 * due, "{degrees}: {force:?}");
        }
        let mut heavy = rod_with(&[("end_fitting", &[("mass", 0.05), ("center_of_mass", 0.017)])]);
        heavy.set("rod.base_angle", -90f64.to_radians()).unwrap();
        for degrees in [-120.0_f64, -75.0, -50.0] {
            let angle = degrees.to_radians();
            for end_angle in [None, Some(angle)] {
                let (string, _) = held(&heavy, &Hold { direction: angle, end_angle }).unwrap();
                let ([x, z], _) = end(&string);
                assert!((z.atan2(x) - angle).abs() < 1e-8, "{degrees}: {}", z.atan2(x).to_degrees());
            }
        }
    }

    /// Of a rod that hardly bends the end is nearly in line with the clamp: the other way round is out of its reach.
    #[test]
    fn what_is_out_of_reach_is_refused() {
        let mut model = rod_with(&[]);
        model.set("rod.bending_stiffness", 100.0).unwrap();
        let back = held(&model, &Hold { direction: 3.0, end_angle: Some(0.0) });
        assert!(matches!(back, Err(ModelError::Held { .. })), "{:?}", back.err());
    }
}
