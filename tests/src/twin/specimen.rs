//! A beam together with what is hidden in it: its equations of motion in an implicit step.
//!
//! A stage of such a step ends at `x = x₀ + h ẋ`, with `x₀` and `h` known. So velocities and
//! accelerations follow from coordinates, and memories, whose rates are linear in themselves, from
//! both: only the coordinates are solved for.

use std::ops::Range;

use super::band::Band;
use super::beam::{Beam, CLAMPED, Slopes};
use super::element::{Real, cross, curvature, dot, seed, slopes_of};
use super::hidden::{Gust, Hidden, Occasion, Slosh, Strain, TipState};
use super::site::{Place, Site, sites};

/// A beam and its hidden effects.
#[derive(Clone, Debug)]
pub struct Specimen {
    /// The beam, its data changed by what is hidden.
    pub beam: Beam,
    hidden: Vec<Hidden>,
    /// Range of each effect's memory.
    memory: Vec<Range<usize>>,
    /// Where effects act.
    sites: Vec<Site>,
    occasion: Occasion,
    mass: Band,
}

/// What a stage knows beside its coordinates and their rates.
#[derive(Clone, Copy, Debug)]
pub struct Stage<'a> {
    /// After the release, s.
    pub time: f64,
    /// `h`, s.
    pub reach: f64,
    /// `x₀` of the memories.
    pub memory: &'a [f64],
}

/// Two vectors of a site, or their rates.
type Pair<T> = [[T; 2]; 2];

impl Specimen {
    /// A beam with effects, at one release.
    pub fn new(mut beam: Beam, hidden: &[Hidden], occasion: &Occasion) -> Self {
        hidden.iter().for_each(|effect| effect.alter(&mut beam, occasion));
        let sites = sites(&beam, hidden);
        let points = sites.iter().filter(|site| matches!(site.place, Place::Strain { .. })).count();
        let mut end = 0;
        let range = |effect: &Hidden| {
            let begin = end;
            end += match effect {
                Hidden::Sloshing { .. } => 4,
                effect if effect.remembers() => points,
                _ => 0,
            };
            begin..end
        };
        let memory = hidden.iter().map(range).collect();
        let mass = beam.mass_matrix();
        Self { beam, hidden: hidden.to_vec(), memory, sites, occasion: *occasion, mass }
    }

    /// A beam in which nothing is hidden.
    pub fn plain(beam: &Beam) -> Self {
        Self::new(beam.clone(), &[], &Occasion { pressure: 0.0, diameter: 0.0, drift: 0.0 })
    }

    /// Coordinates, velocities and memories when the straight rod is let go, at an angle from the
    /// clamp's, rad. What creeps is at rest; what sloshes hangs on its spring.
    pub fn let_go(&self, angle: f64) -> [Vec<f64>; 3] {
        let q = self.beam.straight(angle);
        let rate: f64 = self.hidden.iter().map(Hidden::initial_rate).sum();
        let mut v: Vec<f64> = q.chunks(2).flat_map(|x| [-rate * x[1], rate * x[0]]).collect();
        self.held().iter().for_each(|&i| v[i] = 0.0);
        let mut z = vec![0.0; self.memory.last().map_or(0, |range| range.end)];
        for site in self.sites.iter().filter(|site| site.place == Place::Tip) {
            let tip = self.tip_in_world(site.pair(&q), site.pair(&v), 0.0);
            for (effect, range) in self.hidden.iter().zip(&self.memory) {
                if let Hidden::Sloshing { frequency, .. } = effect {
                    let [x, y] = tip.position;
                    let sag = self.beam.gravity / frequency.powi(2);
                    z[range.clone()].copy_from_slice(&[x, y - sag, tip.velocity[0], tip.velocity[1]]);
                }
            }
        }
        [q, v, z]
    }

    /// Coordinates that the clamp holds.
    fn held(&self) -> &'static [usize] {
        if self.clamp_compliance() > 0.0 { &CLAMPED[..2] } else { &CLAMPED }
    }

    fn clamp_compliance(&self) -> f64 {
        self.hidden.iter().map(Hidden::clamp_compliance).sum()
    }

    /// Imbalance `M a + … − forces`, N and N m; rows that the clamp holds are zero.
    pub fn imbalance(&self, stage: &Stage, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
        let mut out = self.beam.unheld_imbalance(&self.mass, q, v, a);
        let mean_square = self.mean_square(q);
        for site in &self.sites {
            let force = self.forces(site, stage, mean_square, [q, v, a].map(|x| site.pair(x)));
            for (i, k) in (0..8).map(|m| (m / 2, m % 2)) {
                let share = site.shapes[0][i] * force[k] + site.shapes[1][i] * force[2 + k];
                out[site.begin + 2 * i + k] += site.weight * share;
            }
        }
        self.held().iter().for_each(|&i| out[i] = 0.0);
        out
    }

    /// Derivative of [`Specimen::imbalance`] by `q`, with `v` and `a` following by `slopes`. The mean
    /// square of the curvature is taken as constant, since its derivative joins all elements.
    pub fn tangent(&self, stage: &Stage, q: &[f64], v: &[f64], a: &[f64], slopes: Slopes) -> Band {
        let mut out = self.beam.unheld_tangent(&self.mass, q, v, a, slopes);
        let mean_square = self.mean_square(q);
        for site in &self.sites {
            let pairs = [(q, 1.0), (v, slopes.velocity), (a, slopes.acceleration)];
            let pairs = pairs.map(|(x, rate)| seed(site.pair(x), rate));
            let by = self.forces(site, stage, mean_square, pairs).map(|force| slopes_of(&force));
            out.add_element(site.begin, &site.shapes, &by, site.weight);
        }
        self.held().iter().for_each(|&i| out.hold(i));
        out
    }

    /// Memories at the end of a stage.
    pub fn memory(&self, stage: &Stage, q: &[f64], v: &[f64]) -> Vec<f64> {
        let mut z = stage.memory.to_vec();
        let mean_square = self.mean_square(q);
        for site in &self.sites {
            let (q, v) = (site.pair(q), site.pair(v));
            for (effect, range) in self.hidden.iter().zip(&self.memory) {
                match site.place {
                    Place::Strain { point, share } if effect.remembers() => {
                        let at = self.strain(share, stage.time, mean_square, q, v);
                        z[range.start + point] = stage.remember(effect, range.start + point, &at);
                    }
                    Place::Tip if matches!(effect, Hidden::Sloshing { .. }) => {
                        let tip = self.tip_in_world(q, v, stage.time);
                        let moved = effect.slosh(&tip, &self.slosh(stage, range));
                        z[range.clone()].copy_from_slice(moved.as_flattened());
                    }
                    _ => {}
                }
            }
        }
        z
    }

    /// Displacement of the tip that a unit of each memory represents, m, in order of size.
    pub fn weight_of_memory(&self) -> Vec<f64> {
        let (length, ei) = (self.beam.length, self.beam.bending_stiffness);
        let weights = self.hidden.iter().zip(&self.memory).flat_map(|(effect, range)| {
            let weight = match effect {
                Hidden::Sloshing { mass, .. } => mass / self.beam.bodies[0].mass,
                effect => effect.weight_of_memory(ei) * length * length,
            };
            range.clone().map(move |_| weight)
        });
        weights.collect()
    }

    /// Mean square of the curvature over the rod, 1/m²; zero if no effect requires it.
    fn mean_square(&self, q: &[f64]) -> f64 {
        if !self.hidden.iter().any(|effect| matches!(effect, Hidden::PressureVolume { .. })) {
            return 0.0;
        }
        let points = self.sites.iter().filter(|site| matches!(site.place, Place::Strain { .. }));
        let squares = points.map(|site| {
            let (kappa, ..) = curvature(site.pair(q));
            site.weight * kappa * kappa
        });
        squares.sum::<f64>() / self.beam.length
    }

    /// What hidden effects add to the imbalance at a site, conjugate to its pair of vectors.
    fn forces<T: Real>(&self, site: &Site, stage: &Stage, mean_square: f64, pairs: [Pair<T>; 3]) -> [T; 4] {
        let [q, v, a] = pairs;
        match site.place {
            Place::Strain { point, share } => {
                let at = self.strain(share, stage.time, mean_square, q, v);
                let mut moment = T::from(0.0);
                for (effect, range) in self.hidden.iter().zip(&self.memory) {
                    let memory = if effect.remembers() {
                        stage.remember(effect, range.start + point, &at)
                    } else {
                        T::from(0.0)
                    };
                    moment += effect.moment(&at, memory);
                }
                let (_, by_p, by_k) = curvature(q);
                [moment * by_p[0], moment * by_p[1], moment * by_k[0], moment * by_k[1]]
            }
            Place::Flow => {
                let diameter = self.occasion.diameter;
                let at = Gust { gradient: q[1], velocity: v[0], acceleration: a[0], diameter };
                let mut out = [T::from(0.0); 4];
                for force in self.hidden.iter().map(|effect| effect.force_per_length(&at)) {
                    (0..2).for_each(|k| out[k] -= force[k]);
                }
                out
            }
            Place::Tip => self.tip_forces(stage, q, v),
            Place::Clamp => turning(q[0], q[0][1].atan2(q[0][0]) / self.clamp_compliance()),
        }
    }

    fn strain<T: Real>(
        &self,
        share: f64,
        time: f64,
        mean_square: f64,
        q: Pair<T>,
        [p_rate, k_rate]: Pair<T>,
    ) -> Strain<T> {
        let (kappa, by_p, by_k) = curvature(q);
        Strain {
            kappa,
            kappa_rate: dot(by_p, p_rate) + dot(by_k, k_rate),
            share,
            length: self.beam.length,
            mean_square,
            time,
            pressure: self.occasion.pressure,
            bending_stiffness: self.beam.bending_stiffness,
        }
    }

    fn tip_forces<T: Real>(&self, stage: &Stage, q: Pair<T>, v: Pair<T>) -> [T; 4] {
        let at = self.tip_in_world(q, v, stage.time);
        let mut sum = [T::from(0.0); 2];
        for (effect, range) in self.hidden.iter().zip(&self.memory) {
            let force = effect.force_at_tip(&at, &self.slosh(stage, range));
            (0..2).for_each(|k| sum[k] += force[k]);
        }
        let force = turn(sum, -self.beam.incline);
        let arm = cross(q[1], force) / dot(q[1], q[1]).sqrt() * self.beam.bodies[0].center;
        let by_p = by_angle(q[1]);
        [-force[0], -force[1], -by_p[0] * arm, -by_p[1] * arm]
    }

    /// The fitting's centre of mass.
    fn tip_in_world<T: Real>(&self, [r, p]: Pair<T>, [v, p_rate]: Pair<T>, time: f64) -> TipState<T> {
        let (center, length) = (self.beam.bodies[0].center, dot(p, p).sqrt());
        let arm = cross(p, p_rate) / dot(p, p) * center / length;
        let position = [0, 1].map(|k| r[k] + p[k] / length * center);
        let velocity = [v[0] - p[1] * arm, v[1] + p[0] * arm];
        let [position, velocity] = [position, velocity].map(|x| turn(x, self.beam.incline));
        TipState { position, velocity, time }
    }

    fn slosh(&self, stage: &Stage, range: &Range<usize>) -> Slosh {
        let known = match stage.memory.get(range.clone()) {
            Some(&[x, y, u, w]) => [[x, y], [u, w]],
            _ => [[0.0; 2]; 2],
        };
        Slosh { known, reach: stage.reach, gravity: self.beam.gravity }
    }
}

impl Stage<'_> {
    /// The memory of an effect at a point at the end of the stage: `z = z₀ + h (a − b z)`.
    fn remember<T: Real>(&self, effect: &Hidden, index: usize, at: &Strain<T>) -> T {
        let [a, b] = effect.memory_rate(at);
        (a * self.reach + self.memory[index]) / (b * self.reach + 1.0)
    }
}

/// Derivative of a gradient's angle by the gradient.
fn by_angle<T: Real>(p: [T; 2]) -> [T; 2] {
    let square = dot(p, p);
    [-p[1] / square, p[0] / square]
}

/// A moment that turns the gradient, the first of a pair.
fn turning<T: Real>(p: [T; 2], moment: T) -> [T; 4] {
    let [x, z] = by_angle(p).map(|by| by * moment);
    [x, z, T::from(0.0), T::from(0.0)]
}

/// A vector turned from x towards z by an angle, rad.
fn turn<T: Real>([x, z]: [T; 2], angle: f64) -> [T; 2] {
    let (sin, cos) = angle.sin_cos();
    [x * cos - z * sin, x * sin + z * cos]
}
