//! Models that the errors of a calibration admit: drawn, or one standard deviation off along each direction.

use efam_core::left_out::{Compact, MEASURE};
use efam_experiments::scenario::Case;
use efam_experiments::scenario::loss::{Loss, POWER};
use models::model::Model;
use models::muscle::{CalibratedParameter, Here, Known, RodSlopes};
use models::quantity::format_si;
use nalgebra::{DMatrix, DVector};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use crate::normal::{NORMAL_95, normal, root};

/// Draws after which one that is not admitted is put on its bounds.
const TRIES: usize = 10_000;
/// Singular values of correlations below this are rounding.
const ROUNDING: f64 = 1e-7;
/// Share of a standard deviation below which a step along a direction says nothing.
const LEAST_SHARE: f64 = 1e-3;

/// The rotary inertia of the payload.
pub const PAYLOAD_INERTIA: &str = "effects.payload.rotary_inertia";

/// The errors of a calibration at the pressure and the frequency of a case.
pub struct Errors {
    /// The model of the case, with its loss at the frequency of the case, and a payload without a size as a compact body.
    pub model: Model,
    drawn: Vec<Drawn>,
    /// The loss that is known at another frequency.
    loss: Option<Loss>,
    /// Whether the case has it so, and says so.
    is_said: bool,
    /// The payload, where its size is not given: its rotary inertia is drawn.
    payload: Option<Compact>,
    /// Takes independent normal numbers to errors; its columns are those of a standard deviation along each direction.
    /// The last error is that of the logarithm of the loss, where that is known at another frequency.
    root: DMatrix<f64>,
    /// Takes the normal numbers of a draw, and one more, to the error of the slope over pressure of the logarithm of the bending
    /// stiffness, 1/Pa.
    slope: (DVector<f64>, f64),
    /// Those that the data did not determine.
    pub undetermined: Vec<CalibratedParameter>,
    /// Of each parameter that was interpolated over pressure its path, and half the 95 % interval that this alone
    /// makes, as a share of its value.
    pub interpolated: Vec<(String, f64)>,
}

/// A parameter that is drawn.
struct Drawn {
    path: String,
    /// Its calibrated value.
    value: f64,
    /// What it may be.
    range: [f64; 2],
    /// Whether its logarithm is normal: so it is of what describes the rod, which is positive.
    is_logarithmic: bool,
}

impl Drawn {
    /// Its value with an error, which is that of the logarithm times the value where it is logarithmic.
    fn with(&self, error: f64) -> f64 {
        if self.is_logarithmic { self.value * (error / self.value).exp() } else { self.value + error }
    }

    /// The largest error of a sign that its range admits, as a size.
    fn room(&self, sign: f64) -> f64 {
        let end = if sign > 0.0 { self.range[1] } else { self.range[0] };
        let room = if self.is_logarithmic { self.value * (end / self.value).ln() } else { end - self.value };
        (room * sign.signum()).max(0.0)
    }

    fn admits(&self, error: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&self.with(error))
    }
}

impl Errors {
    /// Those of a case.
    pub fn new(known: &Known, case: &Case) -> Self {
        let here = |path: &str| {
            // As it was calibrated, whose errors are those of that value.
            let factor = case.loss.as_ref().filter(|loss| loss.path == path).map_or(1.0, |loss| loss.factor);
            let of = |k: usize| Here {
                value: case.model.theta[k] / factor,
                scale: case.model.parameters[k].scale,
            };
            // A parameter that the model has not is left out below.
            case.model.index(path).map_or(Here { value: 0.0, scale: 0.0 }, of)
        };
        let at = known.at(case.pressure.unwrap_or(0.0), &here);
        // A parameter that the model has not is none of its errors.
        let own: Vec<usize> =
            (0..at.paths.len()).filter(|k| case.model.index(&at.paths[*k]).is_ok()).collect();
        let drawn = |k: &usize| {
            let path = &at.paths[*k];
            let value = here(path).value;
            let (low, high) =
                case.model.index(path).map_or((value, value), |k| case.model.parameters[k].range);
            let is_logarithmic = path.starts_with("rod.") && value > 0.0;
            Drawn { path: path.clone(), value, range: [low, high], is_logarithmic }
        };
        let covariance = DMatrix::from_fn(own.len(), own.len(), |a, b| at.covariance[own[a]][own[b]]);
        let mut root = root(&covariance);
        let slope =
            beside(&root, &own.iter().map(|k| at.slope[*k]).collect::<Vec<_>>(), at.slope[at.paths.len()]);
        let mut drawn: Vec<Drawn> = own.iter().map(drawn).collect();
        let mut model = case.model.clone();
        let payload = Compact::of(&model);
        if let Some(payload) = &payload
            && let Ok(k) = model.index(PAYLOAD_INERTIA)
        {
            let (value, count, (low, high)) = (payload.median(), drawn.len(), model.parameters[k].range);
            model.theta[k] = value;
            root = root.resize(count + 1, count + 1, 0.0);
            root[(count, count)] = value * payload.deviation();
            drawn.push(Drawn {
                path: PAYLOAD_INERTIA.to_owned(),
                value,
                range: [low, high],
                is_logarithmic: true,
            });
        }
        let loss = Loss::of(known, &model).filter(|loss| drawn.iter().any(|own| own.path == loss.path));
        if let Some(loss) = &loss {
            let count = drawn.len();
            root = root.resize(count + 1, count + 1, 0.0);
            root[(count, count)] = loss.deviation;
        }
        let is_own = |parameter: &CalibratedParameter| own.iter().any(|k| at.paths[*k] == parameter.path);
        let interpolated = |k: &usize| {
            let (path, deviation) = (&at.paths[*k], at.interpolated[*k]);
            (deviation > 0.0).then(|| (path.clone(), NORMAL_95 * deviation / here(path).value.abs()))
        };
        let (interpolated, undetermined) = (
            own.iter().filter_map(interpolated).collect(),
            at.undetermined.into_iter().filter(is_own).collect(),
        );
        let is_said = case.loss.is_some();
        let mut errors =
            Self { model, drawn, loss, is_said, payload, root, slope, interpolated, undetermined };
        if (errors.loss.is_some() || errors.payload.is_some())
            && let Some(model) = errors.model(&DVector::zeros(errors.root.nrows()))
        {
            errors.model = model;
        }
        errors
    }

    /// What should be known of the loss, in words.
    pub fn of_loss(&self) -> Option<String> {
        let loss = self.loss.as_ref()?;
        let own = self.drawn.iter().find(|own| own.path == loss.path)?;
        let taken = loss.words(own.value, self.unit(&own.path))?;
        let interval = format!(
            "the intervals hold a damping ratio that goes with the frequency to the power ±{:.1} (95 %)",
            NORMAL_95 * POWER
        );
        Some(if self.is_said { interval } else { format!("{taken}; {interval}") })
    }

    /// What should be known of a payload without a size, in words.
    pub fn of_payload(&self) -> Option<String> {
        let payload = self.payload.as_ref()?;
        let median = format_si(payload.median(), self.unit(PAYLOAD_INERTIA));
        let taken = format!("its rotary inertia is taken as {median}");
        Some(format!("{}; the intervals include that; {MEASURE}", payload.words(&taken)))
    }

    /// The model of a draw, the same for every caller; none that makes no sense. Errors that take a number
    /// out of what it may be are drawn anew: of two that move against one another, neither gives way alone.
    pub fn drawn(&self, seed: u64, draw: usize) -> Option<Model> {
        self.model(&self.errors(seed, draw))
    }

    /// Whether anything is known of the slope of the bending stiffness over pressure.
    pub fn has_slope(&self) -> bool {
        self.slope.1 > 0.0 || self.slope.0.iter().any(|by_normal| *by_normal != 0.0)
    }

    /// How the rod of the same draw follows the pressure, from how the table says that it does.
    pub fn slopes(&self, seed: u64, draw: usize, [length, bending, axial, diameter]: RodSlopes) -> RodSlopes {
        let (by_normals, deviation) = &self.slope;
        let (normals, one_more) = self.normals(seed, draw);
        let error = by_normals.dot(&normals.rows(0, by_normals.len())) + deviation * one_more;
        [length, bending + error, axial, diameter]
    }

    /// What the model of a draw has of its own: paths and values.
    pub fn values(&self, seed: u64, draw: usize) -> Vec<(String, f64)> {
        let errors = self.errors(seed, draw);
        self.with(&errors).map(|(path, value)| (path.to_owned(), value)).collect()
    }

    /// Paths and values with these errors, as far as the values may go.
    fn with<'a>(&'a self, errors: &'a DVector<f64>) -> impl Iterator<Item = (&'a str, f64)> {
        let own = |of: &Drawn| self.loss.as_ref().filter(|loss| loss.path == of.path);
        let at_frequency =
            move |of: &Drawn| own(of).map_or(1.0, |loss| loss.factor * errors[self.drawn.len()].exp());
        let value = move |(of, error): (&Drawn, &f64)| at_frequency(of) * of.with(*error);
        let pairs = self.drawn.iter().zip(errors.iter());
        pairs.map(move |pair| (&pair.0.path[..], value(pair).clamp(pair.0.range[0], pair.0.range[1])))
    }

    fn errors(&self, seed: u64, draw: usize) -> DVector<f64> {
        &self.root * self.normals(seed, draw).0
    }

    /// Independent normal numbers whose errors are admitted, and one more.
    fn normals(&self, seed: u64, draw: usize) -> (DVector<f64>, f64) {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed.wrapping_add((draw as u64) << 20));
        let mut draw = || DVector::from_fn(self.directions(), |_, _| normal(&mut random));
        let mut normals = draw();
        for _ in 0..TRIES {
            if self.admits(&(&self.root * &normals)) {
                break;
            }
            normals = draw();
        }
        (normals, normal(&mut random))
    }

    /// SI unit of a parameter; empty if it has none.
    pub fn unit(&self, path: &str) -> &'static str {
        self.model.index(path).map_or("", |k| self.model.parameters[k].unit)
    }

    /// How many directions there are.
    pub fn directions(&self) -> usize {
        self.root.ncols()
    }

    /// The model one standard deviation along a direction, or as far as its numbers may go, with how far that is, and
    /// how far they may go in all, in standard deviations. There is no model where they cannot go at all.
    pub fn along(&self, direction: usize, side: f64) -> (Option<(Model, f64)>, f64) {
        let errors = side * self.root.column(direction);
        let reach = |(of, error): (&Drawn, &f64)| {
            if *error == 0.0 { f64::INFINITY } else { of.room(*error) / error.abs() }
        };
        let room = self.drawn.iter().zip(errors.iter()).map(reach).fold(f64::INFINITY, f64::min);
        if room < LEAST_SHARE {
            return (None, 0.0);
        }
        let share = room.min(1.0);
        (self.model(&(share * errors)).map(|model| (model, share)), room)
    }

    fn admits(&self, errors: &DVector<f64>) -> bool {
        let mut pairs = self.drawn.iter().zip(errors.iter());
        pairs.all(|(of, error)| of.admits(*error))
    }

    fn model(&self, errors: &DVector<f64>) -> Option<Model> {
        let mut model = self.model.clone();
        for (path, value) in self.with(errors) {
            model.set(path, value).ok()?;
        }
        Some(model)
    }
}

/// How a number with these covariances with others and this variance follows from the normal numbers that a root takes to
/// those, and from one more.
fn beside(root: &DMatrix<f64>, covariances: &[f64], variance: f64) -> (DVector<f64>, f64) {
    let scale = |k: usize| root.row(k).norm().max(f64::MIN_POSITIVE).recip();
    let scaled = DMatrix::from_fn(root.nrows(), root.ncols(), |k, l| scale(k) * root[(k, l)]);
    let covariances = DVector::from_fn(covariances.len(), |k, _| scale(k) * covariances[k]);
    // Of numbers that are known to follow from one another, any share does.
    let inverse = scaled.pseudo_inverse(ROUNDING).expect("the bound is positive");
    let by_normals = inverse * covariances;
    let left = (variance - by_normals.norm_squared()).max(0.0).sqrt();
    (by_normals, left)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use models::statics::{equilibrium, modes};

    use super::*;
    use crate::predict::request::CaseRequest;

    /// A silicone beam that was calibrated bare, its EI known to 0.01 %.
    const BEAM: &str = "[rod]\nlength = \"0.1 m\"\nmass = \"96.3 g\"\nbending_stiffness = \"0.01781 N m^2\"\nnodes = 16\n\
                        [effects.rayleigh_mass]\nalpha = \"1 1/s\"\n[run]\nduration = \"1 s\"\n\
                        [calibration]\nreleases = 1\npressure_pa = [0.0, 0.0]\npayload_kg = [0.0, 0.0]\n\
                        excursion_m = 0.02\n[[calibration.parameter]]\npath = \"rod.bending_stiffness\"\n\
                        value = 0.01781\nstandard_error = 1.8e-6\ncorrelations = [1.0]\n";

    fn frequency(model: &Model) -> f64 {
        let rest = equilibrium(model, None).expect("it hangs");
        modes(model, &rest, 1).expect("it swings")[0].angular_frequency
    }

    /// Goal: a payload without a size has the inertia of a compact body in the interval. Expected: with 104 g the frequency
    /// is 0.77 to 9.8 % below that of a point, as Ritz's method has it, and recordings of such a beam were 2.5 to
    /// 4.4 % below. A size that is given, and a rod without a payload, have the width of EI alone.
    #[test]
    fn a_payload_without_a_size_is_in_the_interval() {
        let request = CaseRequest::scenario(Path::new("rod.toml"), BEAM.to_owned());
        let below = |payload: f64, inertia: f64| {
            let (mut case, known) = request.case(None, Some(payload)).expect("a case");
            let point = frequency(&case.model);
            case.model.set(PAYLOAD_INERTIA, inertia).expect("admissible");
            let errors = Errors::new(&known.expect("a calibration"), &case);
            let draw = |draw: usize| 1.0 - frequency(&errors.drawn(1, draw).expect("a model")) / point;
            let mut all: Vec<f64> = (0..200).map(draw).collect();
            all.sort_by(f64::total_cmp);
            ([all[5], all[194]], 1.0 - frequency(&errors.model) / point, errors.of_payload())
        };
        let ([low, high], value, words) = below(0.104, 0.0);
        // The ends of 200 draws are known to a tenth of the width.
        assert!((low - 0.0077).abs() < 0.006 && (high - 0.0977).abs() < 0.03, "{low} to {high}");
        assert!((value - 0.028).abs() < 0.002 && low < 0.025 && high > 0.044, "{value}");
        assert!(
            words
                .is_some_and(|words| words.contains("104 g has no size") && words.contains("steel or water"))
        );
        for (payload, inertia) in [(0.0, 0.0), (0.104, 3e-5)] {
            let ([low, high], _, words) = below(payload, inertia);
            assert!(high - low < 1e-3 && words.is_none(), "{low} to {high}");
        }
    }
}
