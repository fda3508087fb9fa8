//! How to run a model, as data.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use models::error::ModelError;
use models::history::History;
use models::model::Model;

use crate::initial::Initial;
use crate::integrate::{DEFAULT_MOST_STEPS, Method, Steps};
use crate::point::Point;
use crate::work::Work;

pub use crate::integrate::DEFAULT_TOLERANCE;

/// How to run a model.
///
/// ```
/// use efam_core::integrate::{Method, Steps};
/// use efam_core::run::Run;
///
/// // Two seconds, stored 100 times each, with error control.
/// let run = Run::release(2.0, 100.0);
/// assert_eq!((run.samples.len(), run.tolerance), (201, 1e-6));
/// // The same in steps of half a millisecond, without.
/// let study = Run { method: Method::Rodas4, steps: Steps::Fixed(5e-4), ..run };
/// assert_eq!(study.steps.fixed(), Some(5e-4));
/// ```
#[derive(Clone, Debug)]
pub struct Run {
    /// Where it starts.
    pub initial: Initial,
    /// What the memory of the effects has seen before; none: it is relaxed where the rod starts.
    pub history: Option<History>,
    /// End of the run, s after release; later where the recording's clock requires it.
    pub duration: f64,
    /// Times at which the trajectory is sampled, s, ascending: of states since release, of the points
    /// by the clock of what observes.
    pub samples: Vec<f64>,
    /// Integrator.
    pub method: Method,
    /// Error admitted in a step, see [`Control::tolerance`](crate::integrate::Control::tolerance).
    pub tolerance: f64,
    /// How long the steps are.
    pub steps: Steps,
    /// Steps after which to give up.
    pub most_steps: usize,
    /// Whether the trajectory keeps its samples; if not, only who observes sees them, and memory stays flat.
    pub keep_samples: bool,
    /// Whether to keep where the steps ended, so that another run can be made on them.
    pub keep_steps: bool,
    /// Whether to follow dissipated and supplied energy.
    pub energy: bool,
    /// Parameters, as indices into `theta`, by which to differentiate the path of the tip, and those
    /// of the points as they are observed.
    ///
    /// ```
    /// use std::ops::ControlFlow;
    ///
    /// use efam_core::forward::{Run, forward};
    /// # use models::effects::Rod;
    /// # use models::model::{Model, ModelSpec};
    /// # let rod = Rod { length: 0.2, mass: 0.03, bending_stiffness: 5e-3, axial_stiffness: 500.0, diameter: 0.03,
    /// #     pressure: 0.0 };
    /// # let mut model = Model::new(&ModelSpec { nodes: 12, ..ModelSpec::of(rod) }.with(&[("rayleigh_mass.alpha", 1.0),
    /// #     ("rayleigh_stiffness.beta", 2e-3)]))?;
    ///
    /// let stiffness = model.index("rod.bending_stiffness")?;
    /// let run = Run { sensitivities: vec![stiffness], ..Run::release(0.5, 100.0) };
    /// let path = forward(&model, &run, &mut |_| ControlFlow::Continue(()))?;
    /// // How far the tip is higher after half a second for each N m² more.
    /// let slope = path.tip_by_parameters[50][0][1];
    /// # model.set("rod.bending_stiffness", 5.001e-3)?;
    /// # let stiffer = forward(&model, &run, &mut |_| ControlFlow::Continue(()))?;
    /// # let difference = (stiffer.tip[50][1] - path.tip[50][1]) / 1e-6;
    /// # assert!((slope / difference - 1.0).abs() < 0.02, "{slope} {difference}");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub sensitivities: Vec<usize>,
    /// Further points whose paths are recorded.
    pub points: Vec<Point>,
    /// Time between points of the [trace](crate::trajectory::Trajectory::trace) of the tip, s, which is taken beside the samples;
    /// none for no trace.
    pub trace_step: Option<f64>,
    /// Ends the run before its next step.
    pub cancel: Cancel,
    /// Counts the steps of the run, together with those of others.
    pub work: Work,
}

/// A request to end a run, shared with whoever makes it.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Option<Arc<AtomicBool>>);

impl Cancel {
    /// Ends runs once the flag is set.
    pub fn by(flag: Arc<AtomicBool>) -> Self {
        Self(Some(flag))
    }

    /// Whether the flag is set.
    pub fn is_requested(&self) -> bool {
        self.0.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))
    }
}

/// The default integrator of a run.
pub const DEFAULT_METHOD: Method = Method::Auto;
/// Tolerance of fits and sweeps: the tip of the paper's muscle stays within 0.05 mm rms.
pub const FAST_TOLERANCE: f64 = 3e-5;

impl Run {
    /// A release with default settings, sampled `rate` times a second.
    pub fn release(duration: f64, rate: f64) -> Self {
        Self {
            initial: Initial::Straight,
            history: None,
            duration,
            samples: uniform(duration, rate),
            method: DEFAULT_METHOD,
            tolerance: DEFAULT_TOLERANCE,
            steps: Steps::Adaptive,
            most_steps: DEFAULT_MOST_STEPS,
            keep_samples: true,
            keep_steps: false,
            energy: false,
            sensitivities: Vec::new(),
            points: Vec::new(),
            trace_step: Some(1.0 / rate),
            cancel: Cancel::default(),
            work: Work::default(),
        }
    }

    /// The same model and run on another mesh.
    /// # Errors
    /// [`ModelError::Nodes`].
    pub fn on_mesh(&self, model: &Model, nodes: usize) -> Result<(Model, Run), ModelError> {
        Ok((model.with_nodes(nodes)?, Run { initial: self.initial.on_mesh(nodes)?, ..self.clone() }))
    }
}

/// Times from zero to `duration`, `rate` a second, both ends included where they fall on a sample.
pub fn uniform(duration: f64, rate: f64) -> Vec<f64> {
    let count = (duration * rate * (1.0 + 1e-12)).floor() as usize;
    (0..=count).map(|k| k as f64 / rate).collect()
}
