//! The laws of a [`Definition`], evaluated.

use super::names::{self, out};
use super::{Definition, LawError, about};
use crate::effects::{
    About, Bend, Edge, Flow, Kind, Law, Mass, MassLoad, Moment, Place, Reach, Real, Tip, TipLoad,
};
use crate::formula::Program;

/// A law whose formulas were text.
pub struct WrittenLaw {
    about: &'static About,
    text: String,
    page: String,
    /// In the order of [`names::OUTPUTS`].
    programs: [Option<Program>; names::OUTPUTS.len()],
    /// Whether the energy of a bend and of an edge is the integral of what is there at rest.
    integrated: [bool; 2],
    needs_diameter: bool,
}

impl WrittenLaw {
    pub fn new(definition: &Definition) -> Result<Self, LawError> {
        let read = about::read(definition)?;
        Ok(Self {
            about: read.about,
            text: definition.text(),
            page: definition.page(read.about),
            programs: read.programs,
            integrated: read.integrated,
            needs_diameter: read.needs_diameter,
        })
    }

    fn value<T: Real>(&self, output: usize, seen: impl Fn(u8) -> T, theta: &[T]) -> T {
        self.programs[output].as_ref().map_or_else(|| T::from(0.0), |program| program.value(&seen, theta))
    }
}

/// Points and weights of Gauss and Legendre on 0 to 1: right for polynomials up to the degree 15.
const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_884, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_63, 0.111_190_517_226_687_24),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_64),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_64),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_24),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// What a strain stores that was built up from none, at rest: for a stress of this strain.
pub fn integral<T: Real>(strain: T, stress: impl Fn(T) -> T) -> T {
    GAUSS.iter().fold(T::from(0.0), |sum, (point, weight)| sum + stress(strain * *point) * strain * *weight)
}

impl Law for WrittenLaw {
    /// Where a text can act.
    const ABOUT: About = About {
        name: "law",
        meaning: "a law as text",
        kind: Kind::Dissipative,
        places: &[Place::Bend, Place::Whole, Place::Edge, Place::Flow, Place::Mass, Place::Tip, Place::Clamp],
        memory: 1,
        timed: false,
        parameters: &[],
        signature: "",
        confounded_with: &[],
        separated_by: &[],
        reach: Reach::Muscle,
    };

    fn about(&self) -> &'static About {
        self.about
    }
    fn page(&self) -> Option<&str> {
        Some(&self.page)
    }
    fn text(&self) -> Option<&str> {
        Some(&self.text)
    }
    fn needs_diameter(&self) -> bool {
        self.needs_diameter
    }

    fn bend<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> Moment<T> {
        let seen = |k| names::of_bend(at, k);
        Moment {
            moment: self.value(out::MOMENT, seen, theta),
            memory_rate: self.value(out::MEMORY, seen, theta),
        }
    }

    fn bend_energy<T: Real>(&self, at: &Bend<T>, theta: &[T]) -> T {
        if !self.integrated[0] {
            return self.value(out::ENERGY, |k| names::of_bend(at, k), theta);
        }
        integral(at.kappa, |kappa| {
            let at = Bend { kappa, kappa_rate: T::from(0.0), ..*at };
            self.value(out::MOMENT, |k| names::of_bend(&at, k), theta)
        })
    }

    fn edge<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        self.value(out::TENSION, |k| names::of_edge(at, k), theta)
    }

    fn edge_energy<T: Real>(&self, at: &Edge<T>, theta: &[T]) -> T {
        if !self.integrated[1] {
            return self.value(out::EDGE_ENERGY, |k| names::of_edge(at, k), theta);
        }
        integral(at.stretch, |stretch| {
            let at = Edge { stretch, stretch_rate: T::from(0.0), ..*at };
            self.value(out::TENSION, |k| names::of_edge(&at, k), theta)
        })
    }

    fn flow<T: Real>(&self, at: &Flow<T>, theta: &[T]) -> [T; 2] {
        [out::FORCE_ALONG, out::FORCE].map(|output| self.value(output, |k| names::of_flow(at, k), theta))
    }

    fn mass<T: Real>(&self, at: &Mass<T>, theta: &[T]) -> MassLoad<T> {
        let of = |output| self.value(output, |k| names::of_mass(at, k), theta);
        MassLoad { acceleration: [of(out::ACCELERATION_X), of(out::ACCELERATION_Z)], rate: of(out::DECAY) }
    }

    fn tip<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> TipLoad<T> {
        let of = |output| self.value(output, |k| names::of_tip(at, k), theta);
        TipLoad { force: [of(out::FORCE_X), of(out::FORCE_Z)], moment: of(out::TIP_MOMENT) }
    }

    fn tip_energy<T: Real>(&self, at: &Tip<T>, theta: &[T]) -> T {
        self.value(out::TIP_ENERGY, |k| names::of_tip(at, k), theta)
    }

    fn clamp<T: Real>(&self, theta: &[T]) -> T {
        self.value(out::COMPLIANCE, |_| T::from(0.0), theta)
    }
}
