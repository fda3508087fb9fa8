//! A drawn experiment as a laboratory has it: an experiment file, and one recording for each release.
//!
//! What is hidden is in the head of the file alone. Pressures, angles and the priors of masses, holds,
//! markers and cameras are below it, as a laboratory knows them.

use std::fmt::Write;
use std::path::Path;

use efam_experiments::release::Release;

use super::AS_DRAWN;
use super::drawn::{Plan, Priors};
use super::hidden::Hidden;

/// What is drawn, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Lab {
    /// The words that requested it.
    command: String,
    /// Name of the experiment.
    name: String,
    seed: u64,
    /// Names of what is hidden, with its size at each pressure in what is typical.
    hidden: Vec<(String, Vec<f64>)>,
    /// Gauge pressures, psi.
    pressures: [f64; 3],
    /// Angles above the horizontal of clamp and rod at each pressure, degrees.
    angles: [f64; 2],
    /// Whether EI is taken as the static tips of the muscle's table give it, and the muscle has just that.
    is_static: bool,
}

/// How long each release is seen, s, and the hold before it.
const SEEN: [f64; 2] = [8.0, 0.8];

impl Lab {
    /// What is requested by `FOLDER SEED [EFFECT=SIZE…] [static]`, if that makes sense; the folder's last part
    /// is the name. Three sizes between commas are one for each pressure.
    pub fn asked(words: &[String]) -> Option<Lab> {
        let [folder, seed, hidden @ ..] = words else { return None };
        let (hidden, is_static) = match hidden {
            [hidden @ .., last] if last == "static" => (hidden, true),
            hidden => (hidden, false),
        };
        let effect = |word: &String| {
            let (name, sizes) = word.split_once('=')?;
            Hidden::named(name, 1.0)?;
            let sizes: Vec<f64> = sizes.split(',').map(|size| size.parse().ok()).collect::<Option<_>>()?;
            match sizes[..] {
                [size] => Some((name.to_owned(), vec![size; 3])),
                [_, _, _] => Some((name.to_owned(), sizes)),
                _ => None,
            }
        };
        Some(Lab {
            command: words.join(" "),
            name: Path::new(folder).file_name()?.to_str()?.to_owned(),
            seed: seed.parse().ok()?,
            hidden: hidden.iter().map(effect).collect::<Option<_>>()?,
            pressures: if is_static { [10.0, 40.0, 100.0] } else { [15.0, 40.0, 70.0] },
            angles: if is_static { [0.0, 0.0] } else { [0.0, -25.0] },
            is_static,
        })
    }

    /// The experiment file.
    pub fn experiment(&self) -> String {
        let mut text = self.head();
        for (psi, a) in self.releases() {
            let angle = self.angles[a];
            let _ = write!(
                text,
                "\n[[recording]]\nfile = \"{}\"\npressure = \"{psi} psi\"\ntip = \"tip\"\nup = \"+z\"\n\
                 along = \"+x\"\nbase_angle = \"{angle} deg\"\nangle = \"{angle} deg\"\noffset = \"none\"\n",
                file_name(psi, a)
            );
        }
        self.beliefs(&mut text);
        text
    }

    /// The recordings with their names.
    pub fn recordings(&self) -> Vec<(String, String)> {
        let drawn: Vec<_> = (0..3).map(|p| self.plan(p).draw(self.seed)).collect();
        let count = self.angles.len();
        let of = |(k, (psi, a)): (usize, (f64, usize))| {
            (file_name(psi, a), millimetres(&drawn[k / count].releases[k].release, 3, 2))
        };
        self.releases().enumerate().map(of).collect()
    }

    /// Pressure, psi, and number of the angle of each release.
    fn releases(&self) -> impl Iterator<Item = (f64, usize)> {
        self.pressures.iter().flat_map(|psi| (0..self.angles.len()).map(|a| (*psi, a)))
    }

    /// The whole experiment with what is hidden at one pressure: what a plan draws by chance does not
    /// depend on what is hidden.
    fn plan(&self, pressure: usize) -> Plan {
        let hidden = self.hidden.iter().filter_map(|(name, sizes)| Hidden::named(name, sizes[pressure]));
        let hidden: Vec<Hidden> = hidden.collect();
        let usual = Plan::usual(&hidden);
        let bending_stiffness = if self.is_static { 0.0 } else { usual.priors.bending_stiffness };
        Plan {
            pressures: self.pressures.to_vec(),
            angles: self.angles.map(f64::to_radians).to_vec(),
            duration: SEEN[0],
            hold: SEEN[1],
            priors: Priors { bending_stiffness, ..usual.priors },
            ..usual
        }
    }

    fn head(&self) -> String {
        let [a, b, c] = self.pressures;
        let sized = |(name, sizes): &(String, Vec<f64>)| match sizes[..] {
            [x, y, z] if x != y || y != z => {
                format!("{name}, {x}, {y} and {z} times its typical size at {a}, {b} and {c} psi")
            }
            _ => format!("{name}, {} times its typical size", sizes[0]),
        };
        let hidden = if self.hidden.is_empty() {
            "nothing".to_owned()
        } else {
            self.hidden.iter().map(sized).collect::<Vec<_>>().join("; ")
        };
        let paper = if self.is_static { PAPER } else { "" };
        let Priors { alpha, beta, .. } = Priors::default();
        format!(
            "# Purpose: recordings of which it is known what the model below lacks: {hidden}.\n\
             # Expected: `efam diagnose` on this file; docs/src/validation/examples.md has its answer.\n{paper}\
             #\n# Drawn, not measured: by the independent beam of the tests, which shares no law, mesh or\n\
             # integrator with the model below. {}, hold, offset and tilt are off by what a laboratory\n\
             # would not notice. To the bit again from the project's root by\n\
             #   cargo run -p efam-tests --bin draw_experiment -- {}\n\
             name = \"{}\"\n\n[muscle]\nname = \"garbulinski-2022\"\n\n{AS_DRAWN}\n\
             [effects.rayleigh_mass]\nalpha = \"{:.1} 1/s\"             # a first value; it is fitted\n\n\
             [effects.rayleigh_stiffness]\nbeta = \"{} ms\"               # likewise\n",
            if self.is_static { "Masses" } else { "EI, masses" },
            self.command,
            self.name,
            0.5 * (alpha[0] + alpha[1]),
            500.0 * (beta[0] + beta[1])
        )
    }

    /// The priors of a laboratory's setup, in the words of `[calibrate]`.
    fn beliefs(&self, text: &mut String) {
        let Priors { hold_angle, offset, mass, .. } = Priors::default();
        let _ = write!(
            text,
            "\n[calibrate]\nhold_angle = \"{:.2} deg\"      # of each hold, off its angle\n\
             offset = \"{:.1} mm\"           # of the marker, off its place\n",
            hold_angle.to_degrees(),
            1e3 * offset
        );
        let stiffness = ("rod.bending_stiffness", "per_pressure");
        let losses =
            [("effects.rayleigh_mass.alpha", "shared"), ("effects.rayleigh_stiffness.beta", "shared")];
        for (path, scope) in (!self.is_static).then_some(stiffness).into_iter().chain(losses) {
            let _ = write!(text, "\n[[calibrate.parameter]]\npath = \"{path}\"\nscope = \"{scope}\"\n");
        }
        let (muscle, _) = super::table(self.pressures[0]);
        let weighed = [
            ("rod.mass", muscle.rest.mass_per_length * muscle.rest.length),
            ("effects.end_fitting.mass", muscle.end_fitting.mass),
        ];
        for (path, kg) in weighed {
            let _ = write!(
                text,
                "\n[[calibrate.parameter]]\npath = \"{path}\"\nscope = \"shared\"\nprior = \"{:.3} g\"\n\
                 deviation = \"{:.3} g\"        # weighed to a per cent\n",
                1e3 * kg,
                1e3 * kg * mass / 3f64.sqrt()
            );
        }
    }
}

/// What the file of a static case says of itself.
const PAPER: &str = "#\n# After the paper, whose statics do not explain its dynamics: with the EI of its static tips the model\n\
    # slows from 10 to 70 psi by a third, and stays slow; the paper saw a spread of 20 %, its minimum at\n\
    # 30 to 40 psi, and a rise above. The paper gives these trends and no trajectory, so nothing here was\n\
    # measured on its muscle. The muscle drawn here rests as the table says, and a viscoelastic branch\n\
    # that grows with the pressure stiffens it in motion. A branch of one size, as Dahl friction of one\n\
    # size, makes the spread only larger (68 to 82 %). With branches of 0.1, 2 and 2 times EI at 10, 40 and\n\
    # 100 psi the frequencies are 1.65, 1.38 and 1.50 Hz: 20 % apart, the least at 40 psi. That the muscle\n\
    # has these sizes is not claimed. EI is not fitted: it is that of the table.\n";

/// A release as a file: times from its first sample on, its tracks in the plane in mm, to so many decimals of
/// each; what was lost is blank.
pub fn millimetres(release: &Release, of_times: usize, of_places: usize) -> String {
    let mut text = String::from("t_s");
    for track in &release.tracks {
        let _ = write!(text, ",{0}_x_mm,{0}_z_mm", track.marker);
    }
    for (k, time) in release.time.iter().enumerate() {
        let _ = write!(text, "\n{:.of_times$}", time - release.time[0]);
        for track in &release.tracks {
            match track.position[k] {
                Some([x, z]) => {
                    let _ = write!(text, ",{:.of_places$},{:.of_places$}", 1e3 * x, 1e3 * z);
                }
                None => text.push_str(",,"),
            }
        }
    }
    text.push('\n');
    text
}

fn file_name(psi: f64, angle: usize) -> String {
    format!("{psi}psi-{}.csv", angle + 1)
}
