//! The points of a design: each the same for every caller, whatever others are requested.

use efam_experiments::scenario::{Case, Scenario, ScenarioError, ScenarioProblem};
use efam_inference::normal::uniform;
use efam_inference::predict::errors::{Errors, PAYLOAD_INERTIA};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

use super::key::{ValueKind, Varying};
use super::point::case;
use super::request::{Design, OfScenario, Values};
use super::row::{DesignValue, Point};

/// Where points come from.
pub(super) struct Sampler<'a> {
    asked: &'a OfScenario,
    /// Keys of all that has a value at each point: first what varies, then what is drawn.
    pub paths: Vec<String>,
    /// Of each range of a Latin hypercube the layer of each point.
    layers: Vec<Vec<u32>>,
    /// What is drawn from, where it is the same for all points.
    drawn: Option<(Case, Scenario)>,
}

impl<'a> Sampler<'a> {
    /// Of a sweep.
    /// # Errors
    /// [`ScenarioError`] where the first point makes no case whose errors could be drawn.
    pub fn new(asked: &'a OfScenario) -> Result<Self, ScenarioError> {
        let layers = match asked.design {
            Design::LatinHypercube => {
                (0..asked.parameters.len()).map(|k| shuffled(asked.points, asked.seed, k)).collect()
            }
            _ => Vec::new(),
        };
        let paths = asked.parameters.iter().map(|own| own.path.clone()).collect();
        let mut sampler = Sampler { asked, paths, layers, drawn: None };
        if asked.design == Design::Posterior {
            let first = sampler.to_draw_from(&sampler.varied(0))?;
            let known = first.1.known().expect("a posterior was requested with a calibration");
            let keys = Varying::of(&asked.scenario, &asked.scenario_text)?;
            for (path, _) in Errors::new(known, &first.0).values(0, 0) {
                if !matches!(keys.kind(&path), Some(ValueKind::Quantity(_))) || asked.varies(&path) {
                    let message =
                        format!("{path} is drawn from the calibration; leave it out of the parameters");
                    return Err(ScenarioError {
                        at: None,
                        problem: ScenarioProblem::Other { message }.into(),
                    });
                }
                sampler.paths.push(path);
            }
            let inertia = PAYLOAD_INERTIA.to_owned();
            if asked.varies("effects.payload.mass") && !sampler.paths.contains(&inertia) {
                sampler.paths.push(inertia);
            }
            sampler.drawn = asked.parameters.is_empty().then_some(first);
        }
        Ok(sampler)
    }

    /// A point.
    /// # Errors
    /// [`ScenarioError`] where its case has no errors that could be drawn.
    pub fn point(&self, index: usize) -> Result<Point, ScenarioError> {
        let mut point = self.varied(index);
        if self.asked.design == Design::Posterior {
            let own;
            let (case, scenario) = match &self.drawn {
                Some(all) => all,
                None => {
                    own = self.to_draw_from(&point)?;
                    &own
                }
            };
            let known = scenario.known().expect("a posterior was requested with a calibration");
            let drawn = Errors::new(known, case).values(point.seed, 0);
            // A point without a payload draws no inertia of one.
            let value =
                |path: &String| drawn.iter().find(|(own, _)| own == path).map_or(0.0, |(_, value)| *value);
            let paths = &self.paths[self.asked.parameters.len()..];
            point.values.extend(paths.iter().map(|path| DesignValue::Number(value(path))));
        }
        Ok(point)
    }

    /// A point without what is drawn.
    fn varied(&self, index: usize) -> Point {
        let asked = self.asked;
        let mut random = random(asked.seed, index as u64);
        // Every tool reads so large a whole number to the last bit.
        let seed = random.next_u64() >> 11;
        let mut values = Vec::with_capacity(asked.parameters.len());
        let mut of_grid = index;
        for (k, own) in asked.parameters.iter().enumerate().rev() {
            let value = match (asked.design, &own.values) {
                (Design::Grid, Values::List(all)) => {
                    let value = all[of_grid % all.len()].clone();
                    of_grid /= all.len();
                    value
                }
                (Design::Grid, Values::Range { .. }) => unreachable!("a grid has steps"),
                (Design::LatinHypercube, values) => {
                    let share =
                        (f64::from(self.layers[k][index]) + uniform(&mut random)) / asked.points as f64;
                    values.at(share, own.kind)
                }
                (Design::Sobol, values) => {
                    let share = sobol_burley::sample(index as u32, k as u32, mixed(asked.seed));
                    values.at(f64::from(share), own.kind)
                }
                (Design::Posterior, values) => values.at(uniform(&mut random), own.kind),
            };
            values.push(value);
        }
        values.reverse();
        Point { index, seed, values }
    }

    fn to_draw_from(&self, point: &Point) -> Result<(Case, Scenario), ScenarioError> {
        let of_sweep: Vec<String> = self.asked.parameters.iter().map(|own| own.path.clone()).collect();
        case(&self.asked.scenario, &self.asked.scenario_text, &self.asked.set, &of_sweep, point)
    }
}

/// Random numbers of one point, or of something else that is counted.
fn random(seed: u64, index: u64) -> Xoshiro256PlusPlus {
    // Neighbouring seeds are spread by the generator's own seeding.
    let mut of_seed = Xoshiro256PlusPlus::seed_from_u64(seed);
    Xoshiro256PlusPlus::seed_from_u64(of_seed.next_u64().wrapping_add(index))
}

fn mixed(seed: u64) -> u32 {
    (seed ^ (seed >> 32)) as u32
}

/// The numbers below `count` in random order. Source: Durstenfeld (1964), Algorithm 235.
fn shuffled(count: usize, seed: u64, dimension: usize) -> Vec<u32> {
    let mut random = random(seed, u64::MAX - dimension as u64);
    let mut all: Vec<u32> = (0..count as u32).collect();
    for k in (1..count).rev() {
        // Ten million of 2^53: what is uneven about it is below 1e-9.
        let other = (uniform(&mut random) * (k + 1) as f64) as usize;
        all.swap(k, other);
    }
    all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::request::DesignParameter;

    fn asked(design: Design, points: usize, values: &[Values]) -> OfScenario {
        let paths = ["effects.payload.mass", "muscle.pressure", "rod.nodes"];
        let parameter = |(path, values): (&&str, &Values)| DesignParameter {
            path: (*path).to_owned(),
            kind: Varying::default().kind(path).unwrap(),
            values: values.clone(),
        };
        OfScenario {
            scenario: "r.toml".into(),
            scenario_text: String::new(),
            design,
            points,
            seed: 7,
            parameters: paths.iter().zip(values).map(parameter).collect(),
            set: Vec::new(),
        }
    }

    fn points(asked: &OfScenario) -> Vec<Point> {
        let sampler = Sampler::new(asked).unwrap();
        (0..asked.points).map(|index| sampler.point(index).unwrap()).collect()
    }

    fn numbers(points: &[Point], k: usize) -> Vec<f64> {
        let number = |point: &Point| match point.values[k] {
            DesignValue::Number(number) => number,
            DesignValue::Word(_) => panic!("a number"),
        };
        points.iter().map(number).collect()
    }

    const RANGE: Values = Values::Range { low: 2.0, high: 4.0, logarithmic: false };

    #[test]
    fn the_last_of_a_grid_varies_fastest() {
        let list = |all: &[f64]| Values::List(all.iter().map(|value| DesignValue::Number(*value)).collect());
        let grid = points(&asked(Design::Grid, 6, &[list(&[0.0, 1.0]), list(&[5.0, 6.0, 7.0])]));
        assert_eq!(numbers(&grid, 0), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        assert_eq!(numbers(&grid, 1), [5.0, 6.0, 7.0, 5.0, 6.0, 7.0]);
        let seeds: BTreeSet<u64> = grid.iter().map(|point| point.seed).collect();
        assert!(seeds.len() == 6 && seeds.iter().all(|seed| *seed < 1 << 53));
    }

    /// Both designs have a point in each layer of each range: of a hypercube by its making, of Sobol' for powers of
    /// two by the net's definition.
    #[test]
    fn each_layer_has_its_point() {
        for (design, count) in [(Design::LatinHypercube, 100), (Design::Sobol, 128)] {
            let all = points(&asked(design, count, &[RANGE, RANGE]));
            for k in 0..2 {
                let layer = |value: &f64| ((value - 2.0) / 2.0 * count as f64) as usize;
                let layers: BTreeSet<usize> = numbers(&all, k).iter().map(layer).collect();
                assert_eq!(layers.len(), count, "{design:?} {k}");
            }
            assert_ne!(numbers(&all, 0), numbers(&all, 1));
        }
    }

    /// In two dimensions the points of Sobol' fill every elementary box, too, which a hypercube does not.
    #[test]
    fn sobol_fills_boxes() {
        let all = points(&asked(Design::Sobol, 64, &[RANGE, RANGE]));
        let eighth = |value: &f64| ((value - 2.0) / 2.0 * 8.0) as usize;
        let boxes: BTreeSet<_> =
            numbers(&all, 0).iter().map(eighth).zip(numbers(&all, 1).iter().map(eighth)).collect();
        assert_eq!(boxes.len(), 64);
    }

    #[test]
    fn logarithms_counts_and_words_are_spread_as_they_should() {
        let logarithmic = Values::Range { low: 0.1, high: 1000.0, logarithmic: true };
        let kind = ValueKind::Quantity("m");
        assert_eq!(logarithmic.at(0.0, kind), DesignValue::Number(0.1));
        let DesignValue::Number(middle) = logarithmic.at(0.5, kind) else { panic!() };
        assert!((middle - 10.0).abs() < 1e-12);
        assert_eq!(RANGE.at(0.3, ValueKind::Count), DesignValue::Number(3.0));
        let words = Values::List(["a", "b"].map(|word| DesignValue::Word(word.to_owned())).to_vec());
        assert_eq!(words.at(0.49, ValueKind::Word), DesignValue::Word("a".to_owned()));
        assert_eq!(words.at(0.999, ValueKind::Word), DesignValue::Word("b".to_owned()));
    }
}
