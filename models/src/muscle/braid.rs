//! The braid: what its fibres make of a muscle's diameters as it lengthens, and which way it moves.
//!
//! The fibres wind around the bladder at the angle θ to the cross-section and do not stretch. A fibre of the length `b` with
//! `n` turns has `L = b sin θ` and `π n D = b cos θ`, so that
//!
//! ```text
//!   sin θ = (L / L₀) sin θ₀        D = D₀ cos θ / cos θ₀        (D² − d²) L = (D₀² − d₀²) L₀
//! ```
//!
//! The last is the wall, whose volume stays: rubber is incompressible. The volume inside the braid is proportional to
//! `cos² θ sin θ` and largest at `tan² θ = 1/2`, 35.26°. Pressure drives a muscle there: below that angle it lengthens, above
//! it shortens. Sources that measure the angle from the axis have 54.74°.
//!
//! Table 2 of the paper has these outer diameters within 0.0052 in, and these inner ones within 0.0071 in: its last digit
//! is 0.01 in, and so is that of the resting diameters.
//!
//! Source: Garbulinski and Wereley (2022), Bending Properties of an Extensile Fluidic Artificial Muscle, Introduction and
//! below eq. 8; Chou and Hannaford (1996) for the kinematics; Liu and Rahn (2004) for the angle.

use std::fmt::{self, Display};

use super::{Muscle, Rest};
use crate::digits::significant;

/// Which way a muscle moves under pressure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// It lengthens: its braid angle is below 35.26°.
    Extensile,
    /// It shortens: its braid angle is above 35.26°.
    Contractile,
}

/// Braid angle of the largest volume, rad: `tan θ = 1/√2`.
pub fn neutral_angle() -> f64 {
    0.5f64.sqrt().atan()
}

impl Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Motion::Extensile => "extensile",
            Motion::Contractile => "contractile",
        })
    }
}

impl Rest {
    /// Which way the braid moves the muscle under pressure; none without a braid angle.
    pub fn motion(&self) -> Option<Motion> {
        let is_below = |angle: f64| angle < neutral_angle();
        self.braid_angle.map(|angle| if is_below(angle) { Motion::Extensile } else { Motion::Contractile })
    }

    /// Braid angle at an active length, m; none without one at rest, nor where the fibres are straight before that.
    pub fn braid_angle_at(&self, length: f64) -> Option<f64> {
        let sine = self.braid_angle?.sin() * length / self.length;
        (sine < 1.0).then(|| sine.asin())
    }

    /// Outer diameter at an active length by the braid, m; none where angle or resting diameter are not known.
    pub fn outer_diameter_at(&self, length: f64) -> Option<f64> {
        let (angle, outer) = (self.braid_angle?, self.outer_diameter?);
        Some(outer * self.braid_angle_at(length)?.cos() / angle.cos())
    }

    /// Inner diameter at an active length and outer diameter, m, by the volume of the wall; none where the resting
    /// diameters are not known, nor where the wall would fill more than the muscle.
    pub fn inner_diameter_at(&self, length: f64, outer: f64) -> Option<f64> {
        let wall = self.outer_diameter?.powi(2) - self.inner_diameter?.powi(2);
        let square = outer * outer - wall * self.length / length;
        (square >= 0.0).then(|| square.sqrt())
    }
}

/// Share of a diameter that braid and table may differ by: by eq. 8 it is twice that of the axial stiffness, and a muscle's
/// stiffness is seldom known better than to a tenth.
const DIFFERENT: f64 = 0.05;

impl Muscle {
    /// Its name, and which way it moves, in words.
    pub fn described(&self) -> String {
        let Some((motion, angle)) = self.rest.motion().zip(self.rest.braid_angle) else {
            return format!("{}, braid angle not stated", self.name);
        };
        let side = if motion == Motion::Extensile { "below" } else { "above" };
        let [angle, neutral] = [angle, neutral_angle()].map(|angle| significant(angle.to_degrees(), 4));
        format!("{}, {motion}: braid angle {angle} deg, {side} {neutral} deg", self.name)
    }

    /// In what its table contradicts its braid, in words.
    pub fn contradictions(&self) -> Vec<String> {
        let Some((motion, angle)) = self.rest.motion().zip(self.rest.braid_angle) else { return Vec::new() };
        let angle = format!("rest.braid_angle = {} deg", significant(angle.to_degrees(), 4));
        let why = "it is measured from the cross-section: from the axis it is 90 deg less that";
        let mut words = Vec::new();
        let at = |pressure: &f64| (self.length.value(*pressure), self.outer_diameter.value(*pressure));
        let lengths =
            [self.pressure.first(), self.pressure.last()].map(|end| end.map_or(0.0, |end| at(end).0));
        let grows = lengths[1] > lengths[0];
        if lengths[1] != lengths[0] && grows != (motion == Motion::Extensile) {
            let way = if grows { "grow" } else { "fall" };
            words.push(format!(
                "{angle} is that of a {motion} muscle, but the lengths of the table {way}; {why}"
            ));
        }
        let off =
            |(length, outer): (f64, f64)| Some((self.rest.outer_diameter_at(length)? / outer - 1.0).abs());
        let off = self.pressure.iter().filter_map(|pressure| off(at(pressure))).fold(0.0, f64::max);
        if off > DIFFERENT {
            words.push(format!(
                "{angle} gives outer diameters that differ from those of the table by up to {} %, and the table's are \
                 used; {why}",
                significant(100.0 * off, 2)
            ));
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::muscle::{BUILT_IN, Extrapolation};

    const INCH: f64 = 0.0254;

    /// All 20 rows of Table 2. Each diameter misses the table's by no more than two numbers are rounded to: the table's
    /// own, and the one that it starts from, which is a resting one or the measured outer one.
    #[test]
    fn braid_and_wall_give_the_diameters_of_table_2() {
        let muscle = Muscle::built_in("garbulinski-2022").unwrap();
        let rounding = 0.005 * INCH * (1.0 + 1e-9);
        let mut within = 0;
        for &pressure in muscle.pressures() {
            let at = muscle.at(pressure, "pder_32", Extrapolation::Refused).unwrap();
            let outer = muscle.rest.outer_diameter_at(at.length).unwrap();
            let off = (outer - at.outer_diameter).abs();
            assert!(off < 2.0 * rounding, "{pressure}: {off}");
            within += usize::from(off < rounding);
            let wall = |outer: f64| muscle.rest.inner_diameter_at(at.length, outer).unwrap();
            for outer in [outer, at.outer_diameter] {
                let off = (wall(outer) - at.inner_diameter).abs();
                assert!(off < 2.0 * rounding, "{pressure}: {off}");
            }
        }
        assert!(within >= 19, "{within} of 20 outer diameters within the rounding of the table");
    }

    /// The angle of the largest volume, `cos² θ sin θ`, by search; both conventions add up to a right angle.
    #[test]
    fn a_braid_is_neutral_where_its_volume_is_largest() {
        let volume = |angle: f64| angle.cos().powi(2) * angle.sin();
        let neutral = neutral_angle();
        assert!(volume(neutral) > volume(neutral - 1e-4) && volume(neutral) > volume(neutral + 1e-4));
        assert!((neutral.to_degrees() - 35.26).abs() < 5e-3);
        assert!((90.0 - neutral.to_degrees() - 54.74).abs() < 5e-3);
        let rest = Muscle::built_in("garbulinski-2022").unwrap().rest;
        assert_eq!(rest.motion(), Some(Motion::Extensile));
        let steep = Rest { braid_angle: Some(36f64.to_radians()), ..rest };
        assert_eq!(steep.motion(), Some(Motion::Contractile));
        assert_eq!(Rest { braid_angle: None, ..rest }.motion(), None);
    }

    fn altered(pieces: &[(&str, &str)]) -> Result<Muscle, crate::muscle::MuscleError> {
        let exchanged = |text: String, (piece, by): &(&str, &str)| {
            assert!(text.contains(piece), "{piece}");
            text.replace(piece, by)
        };
        Muscle::from_toml(&pieces.iter().fold(BUILT_IN[0].1.to_owned(), exchanged))
    }

    /// The built-in muscle without its columns of diameters.
    const WITHOUT: [(&str, &str); 3] = [
        ("\"length\", \"inner_diameter\", \"outer_diameter\", ", "\"length\", "),
        ("\"psi\", \"in\", \"in\", \"in\",", "\"psi\", \"in\","),
        ("braid_angle = \"12.5 deg\"", "braid_angle = \"ANGLE deg\""),
    ];

    fn without_diameters(angle: &str, rest: &[(&str, &str)]) -> Result<Muscle, crate::muscle::MuscleError> {
        let columns = ["0.97", "0.98", "0.96", "0.95", "0.94", "0.93"];
        let mut text = BUILT_IN[0].1.to_owned();
        for (piece, by) in WITHOUT.iter().chain(rest) {
            text = text.replace(piece, by);
        }
        let row = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            let is_row = line.starts_with("  [") && columns.contains(&cells[2].trim());
            if is_row { [&cells[..2], &cells[4..]].concat().join(",") } else { line.to_owned() }
        };
        let text: Vec<String> = text.lines().map(row).collect();
        Muscle::from_toml(&text.join("\n").replace("ANGLE", angle))
    }

    /// Without columns of diameters they are the braid's, and eq. 8 takes them: within 1.4 % of the paper's EA, which is
    /// what half a hundredth of an inch makes of it. Another angle makes another muscle.
    #[test]
    fn a_muscle_needs_no_columns_of_diameters() {
        let (own, paper) =
            (without_diameters("12.5", &[]).unwrap(), Muscle::built_in("garbulinski-2022").unwrap());
        let of = |muscle: &Muscle, pressure| muscle.at(pressure, "pder_32", Extrapolation::Refused).unwrap();
        for &pressure in paper.pressures() {
            let (own, paper) = (of(&own, pressure), of(&paper, pressure));
            assert!((own.outer_diameter - paper.outer_diameter).abs() < 0.0053 * INCH);
            assert!((own.inner_diameter - paper.inner_diameter).abs() < 0.0072 * INCH);
            assert!((own.axial_stiffness / paper.axial_stiffness - 1.0).abs() < 0.014);
        }
        let other = without_diameters("14", &[]).unwrap();
        let (own, other) = (of(&own, 5e5), of(&other, 5e5));
        assert!(other.outer_diameter < own.outer_diameter && other.axial_stiffness > own.axial_stiffness);
    }

    #[test]
    fn what_the_braid_cannot_give_is_refused_by_name() {
        let says =
            |angle: &str, rest: &[(&str, &str)]| without_diameters(angle, rest).unwrap_err().to_string();
        let fibres = says("30", &[]);
        assert!(fibres.starts_with("table.rows: row 15, length = 13.51 in: must be less than"), "{fibres}");
        let none = says("12.5", &[("braid_angle = \"ANGLE deg\"", "")]);
        assert!(
            none.starts_with("table.columns: \"outer_diameter\" is missing; or give rest.braid_angle"),
            "{none}"
        );
        let flat = says("0", &[]);
        assert_eq!(flat, "rest.braid_angle = 0 deg: must lie between 0 and 90 deg");
        let wall = says("12.5", &[("inner_diameter = \"0.97 in\"", "inner_diameter = \"1.07 in\"")]);
        assert_eq!(wall, "rest.inner_diameter = 1.07 in: must be smaller than rest.outer_diameter");
    }

    /// An angle from the axis is the usual slip.
    #[test]
    fn a_braid_that_contradicts_the_table_is_named() {
        let paper = Muscle::built_in("garbulinski-2022").unwrap();
        assert_eq!(paper.contradictions(), Vec::<String>::new());
        assert_eq!(paper.described(), "garbulinski-2022, extensile: braid angle 12.50 deg, below 35.26 deg");
        let slip = altered(&[("\"12.5 deg\"", "\"77.5 deg\"")]).unwrap().contradictions();
        assert!(slip.len() == 1 && slip[0].contains("a contractile muscle, but the lengths"), "{slip:?}");
        let steep = altered(&[("\"12.5 deg\"", "\"20 deg\"")]).unwrap().contradictions();
        assert!(steep.len() == 1 && steep[0].contains("gives outer diameters that differ"), "{steep:?}");
    }

    /// At 1 / sin 12.5° = 4.62 times its length the fibres are straight.
    #[test]
    fn no_braid_is_longer_than_its_fibres() {
        let rest = Muscle::built_in("garbulinski-2022").unwrap().rest;
        assert!(rest.braid_angle_at(4.6 * rest.length).is_some());
        assert_eq!(rest.braid_angle_at(4.63 * rest.length), None);
        assert_eq!(rest.outer_diameter_at(4.63 * rest.length), None);
    }
}
