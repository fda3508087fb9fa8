//! Which axis of a recording is up, and how surely, where the experiment does not say: by the first fall, or by a rod that hangs.
//!
//! A rod that is held up falls along gravity. One that hangs and is pulled aside begins across it, and rests below its
//! clamp. Where both point along an axis, they are distinguished by the pace of the swing: a level rod that swings with ω
//! has sagged by `g/ω²` at least (1.0 of that with all mass at its end, 1.5 with none), so its end rests below the
//! level by `g/(ω² L)`.

use std::ops::RangeInclusive;

use nalgebra::Vector3;

use super::CleaningError;
use super::cycles::Cut;
use super::decision::Log;
use super::onset::first_fall;
use crate::experiment::{Direction, Entry, Start};

/// Largest angle between the first fall and an axis that is taken as vertical, rad.
const FALL: f64 = 30.0 * DEGREE;
/// The same of a hanging rod.
const HANGING: f64 = 15.0 * DEGREE;
const DEGREE: f64 = std::f64::consts::PI / 180.0;
/// Angle of the clamp below which a rod hangs: its end then rests nearer to straight down than to the level.
const STEEP: f64 = -45.0 * DEGREE;
/// Acceleration of gravity, m/s².
const GRAVITY: f64 = 9.81;
/// Share of the sag of a level rod that its end may lack at most: with less it hangs.
const LEVEL: f64 = 0.5;
/// Sag of a rod that gravity bends from straight, over `g/ω²`: 1.0 to 1.5, and what large swings and dynamic stiffness make of it.
/// What a pressure or a hand has bent moves by any distance.
const SAG: RangeInclusive<f64> = 0.7..=2.2;
/// Sag of a level rod that no error of the axes or of the clamp's place hides, rad.
const CLEAR_SAG: f64 = 10.0 * DEGREE;
/// Passages through the rest that the period is taken from, at most.
const PASSAGES: usize = 7;

/// The text between the axis that was found and how sure it is.
pub const IS_UP: &str = " of the file is up, ";
/// How sure it is.
pub const SURELY: &str = "surely";
const PERHAPS: &str = "perhaps";

/// What is known of a recording before its frame is.
pub(super) struct Known<'a> {
    pub entry: &'a Entry,
    /// Angle of the clamp above the level, rad, if the experiment says it.
    pub base_angle: Option<f64>,
    pub has_base: bool,
    /// The clamp, m, in the recording's frame.
    pub origin: [f64; 3],
    pub time: &'a [f64],
    pub path: &'a [Option<[f64; 3]>],
    pub cuts: &'a [Cut],
}

/// A direction that may be up.
struct Candidate {
    up: Direction,
    /// How far the evidence is from its axis, rad.
    off: f64,
    why: String,
}

impl Known<'_> {
    /// The direction that is up.
    pub fn up(&self, log: &mut Log) -> Result<Direction, CleaningError> {
        if let Some(up) = self.entry.up {
            return Ok(up);
        }
        let (fall, hanging) = (self.fall(), self.hanging());
        let near =
            |candidate: &Option<Candidate>, limit| candidate.as_ref().is_some_and(|own| own.off < limit);
        let (falls, hangs) = (near(&fall, FALL), near(&hanging, HANGING));
        let found = match (fall, hanging) {
            (fall, hanging) if self.is_flat() => self.of_names(fall.as_ref(), hanging.as_ref()),
            (Some(fall), Some(hanging)) if falls && hangs => self.of_both(fall, hanging),
            (Some(fall), _) if falls => {
                let is_sure = self.has_base && fall.off < 0.5 * FALL && self.is_by_gravity(fall.up);
                Some((fall.up, is_sure, fall.why))
            }
            (_, Some(hanging)) if hangs => Some((hanging.up, false, hanging.why)),
            (fall, hanging) => return Err(self.none([fall, hanging])),
        };
        let (up, is_sure, why) = found.ok_or_else(|| self.none([None, None]))?;
        let sure = if is_sure { SURELY } else { PERHAPS };
        log.say("up", format!("{}{IS_UP}{sure}: {why}", up.text()));
        Ok(up)
    }

    fn none(&self, seen: [Option<Candidate>; 2]) -> CleaningError {
        CleaningError::NoVertical {
            file: self.entry.name.clone(),
            why: seen.into_iter().flatten().map(|own| own.why).collect::<Vec<_>>().join(", and "),
            key: self.entry.key.clone(),
        }
    }

    /// By the first fall, which gravity begins.
    fn fall(&self) -> Option<Candidate> {
        if self.shows_no_fall() {
            return None;
        }
        let falls = self.cuts.iter().filter_map(|cut| first_fall(self.path, cut));
        let fall: Vector3<f64> = falls.map(Vector3::from).sum();
        let (down, off) = Direction::nearest(fall.try_normalize(0.0)?.into());
        let up = opposite(down);
        if self.rests_below(down) {
            let whose = self.whose();
            let why =
                format!("the tip begins below its rest, which is as far below {whose} as a level rod sags");
            return Some(Candidate { up: down, off, why });
        }
        let why = format!("the tip first falls {:.1} deg from {}", off / DEGREE, down.text());
        Some(Candidate { up, off, why })
    }

    /// Whether the tip of a recording that begins at a turn rests below the clamp as a level rod does, if the way that it first
    /// moves is up: it then begins at its lowest point.
    fn rests_below(&self, up: Direction) -> bool {
        let below = -self.rest().dot(&Vector3::from(up.unit()));
        self.cuts.iter().all(|cut| cut.hold.len() < 2)
            && self.square().is_some_and(|square| (LEVEL..=*SAG.end()).contains(&(square * below / GRAVITY)))
    }

    /// By where the tip rests.
    fn hanging(&self) -> Option<Candidate> {
        let (down, off) = Direction::nearest(self.rest().try_normalize(0.0)?.into());
        let up = opposite(down);
        let why = format!("the tip rests {:.1} deg from {} of {}", off / DEGREE, down.text(), self.whose());
        Some(Candidate { up, off, why })
    }

    /// From which place its rest is seen.
    fn whose(&self) -> &'static str {
        if self.has_base { "the base" } else { "the origin" }
    }

    /// Where the tip rests, from the clamp, m.
    fn rest(&self) -> Vector3<f64> {
        let from = Vector3::from(self.origin);
        let sum: Vector3<f64> = self.cuts.iter().map(|cut| Vector3::from(cut.rest) - from).sum();
        sum / self.cuts.len().max(1) as f64
    }

    /// Whether the recording begins in mid-swing, or a pressure moves the rod from its rest, up or down.
    fn shows_no_fall(&self) -> bool {
        matches!(self.entry.start, Some(Start::InMotion | Start::Rest))
    }

    /// Whether the file has x and z alone.
    fn is_flat(&self) -> bool {
        self.path.iter().flatten().all(|at| at[1] == 0.0)
    }

    /// In a file that has x and z alone, z is the vertical; its sign is that of the rod that hangs, of the fall, or of the way
    /// from the hold to the rest.
    fn of_names(
        &self,
        fall: Option<&Candidate>,
        hanging: Option<&Candidate>,
    ) -> Option<(Direction, bool, String)> {
        let along_z = |own: &&Candidate| matches!(own.up, Direction::Axis(2, _));
        let named = "the file has x and z alone";
        if let Some(own) = hanging.filter(|own| own.off < HANGING).filter(along_z).or(fall.filter(along_z)) {
            return Some((own.up, true, format!("{named}, and {}", own.why)));
        }
        if self.shows_no_fall() {
            return Some((Direction::Axis(2, 1.0), false, named.to_owned()));
        }
        let sinks: f64 = self.cuts.iter().map(|cut| cut.held[2] - cut.rest[2]).sum();
        let why = format!("{named}, and the tip rests on the other side along z than it is held");
        (sinks != 0.0).then(|| (Direction::Axis(2, sinks.signum()), false, why))
    }

    /// Where both point along axes.
    fn of_both(&self, fall: Candidate, hanging: Candidate) -> Option<(Direction, bool, String)> {
        let both = format!("{}, and {}", fall.why, hanging.why);
        if fall.up == hanging.up {
            return Some((fall.up, true, both));
        }
        if let Some(angle) = self.base_angle {
            let up = if angle < STEEP { hanging.up } else { fall.up };
            return Some((
                up,
                true,
                format!("the clamp is said to stand at {:.0} deg; {both}", angle / DEGREE),
            ));
        }
        let rest = self.rest();
        let Some(square) = self.square() else { return Some((fall.up, false, both)) };
        let sag = GRAVITY / (square * rest.norm());
        let above = rest.dot(&Vector3::from(fall.up.unit())) / rest.norm();
        let hangs = above.abs() < LEVEL * sag;
        let up = if hangs { hanging.up } else { fall.up };
        let which = if hangs { "so it hangs" } else { "so it is level" };
        let why = format!(
            "{both}; at its pace a level rod rests {:.1} deg or more below the level, {which}",
            sag / DEGREE
        );
        let is_sure = sag > CLEAR_SAG && (hangs || above < 0.0 && self.is_by_gravity(fall.up));
        Some((up, is_sure, why))
    }

    /// Whether the way down from hold to rest is that of gravity at the pace of the swing.
    fn is_by_gravity(&self, up: Direction) -> bool {
        let ways = self.cuts.iter().map(|cut| Vector3::from(cut.held) - Vector3::from(cut.rest));
        let way = ways.sum::<Vector3<f64>>() / self.cuts.len().max(1) as f64;
        let sag = |square: f64| square * way.dot(&Vector3::from(up.unit())) / GRAVITY;
        self.square().is_some_and(|square| SAG.contains(&sag(square)))
    }

    /// Square of the angular frequency of the swing between hold and rest, 1/s².
    fn square(&self) -> Option<f64> {
        let halves = self.cuts.iter().filter_map(|cut| self.half_period(cut));
        let (sum, count) = halves.fold((0.0, 0.0), |(sum, count), half| (sum + half, count + 1.0));
        (count > 0.0).then(|| (std::f64::consts::PI * count / sum).powi(2))
    }

    /// Mean time between passages through the rest, s.
    fn half_period(&self, cut: &Cut) -> Option<f64> {
        let way = Vector3::from(cut.held) - Vector3::from(cut.rest);
        let off = |i: usize| {
            Some((self.time[i], (Vector3::from(self.path[i]?) - Vector3::from(cut.rest)).dot(&way)))
        };
        let seen: Vec<(f64, f64)> = cut.swing.clone().filter_map(off).collect();
        let passes =
            seen.windows(2).filter(|pair| pair[0].1.is_sign_positive() != pair[1].1.is_sign_positive());
        let times: Vec<f64> = passes.map(|pair| 0.5 * (pair[0].0 + pair[1].0)).take(PASSAGES).collect();
        let (first, last) = (times.first()?, times.last()?);
        (times.len() > 1).then(|| (last - first) / (times.len() - 1) as f64)
    }
}

fn opposite(direction: Direction) -> Direction {
    match direction {
        Direction::Axis(axis, sign) => Direction::Axis(axis, -sign),
        Direction::Vector(vector) => Direction::Vector(vector.map(|x| -x)),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use efam_recordings::{ReadOptions, parse};

    use crate::cleaning::{Cleaned, IS_UP, clean_all};
    use crate::experiment::{Experiment, ExperimentError};

    /// A tip at 0.4 m from the origin that is held aside for a second by an angle and then swings about `down` with `hertz`; axes
    /// in the order down, aside, across.
    fn cleaned(
        rod: &str,
        aside: f64,
        rest: f64,
        hertz: f64,
        names: [&str; 3],
    ) -> Result<Cleaned, ExperimentError> {
        let mut text = format!("t_s,A_{}_m,A_{}_m,A_{}_m\n", names[0], names[1], names[2]);
        for k in 0..700 {
            let since = (0.01 * f64::from(k) - 1.0).max(0.0);
            let angle =
                rest + aside.to_radians() * (-since).exp() * (std::f64::consts::TAU * hertz * since).cos();
            let across = if names[2] == "y" { 0.0 } else { 0.01 * angle.sin() };
            text += &format!(
                "{:.2},{:.9},{:.9},{across:.9}\n",
                0.01 * f64::from(k),
                -0.4 * angle.cos(),
                0.4 * angle.sin()
            );
        }
        let recording =
            parse(text.into_bytes(), Path::new("a.csv"), &ReadOptions::default()).expect("a table");
        let text = format!("{rod}[[recording]]\nfile = \"a.csv\"\ntip = \"A\"\n");
        let experiment = Experiment::parse(Path::new("e.toml"), &text, &[]).expect("an experiment");
        clean_all(&experiment, vec![recording])
    }

    fn up(rod: &str, aside: f64, hertz: f64, names: [&str; 3]) -> String {
        let cleaned = cleaned(rod, aside, 0.02, hertz, names).expect("a release");
        let decision =
            cleaned.decisions.into_iter().find(|decision| decision.key == "up").expect("it is found");
        let (axis, why) = decision.what.split_once(IS_UP).expect("an axis");
        format!("{axis} {}", why.split(':').next().expect("how sure"))
    }

    /// A pendulum of 0.4 m swings with 0.79 Hz as a point and 0.97 as a bar; a pull of less than some 30 degrees begins across
    /// gravity. The first fall alone said +y and +x.
    #[test]
    fn a_rod_that_hangs_is_not_taken_for_a_level_one() {
        for aside in [8.0, 15.0, 25.0] {
            for hertz in [0.9, 1.4, 1.7] {
                assert_eq!(up("", aside, hertz, ["z", "x", "y"]), "+z surely", "{aside} deg, {hertz} Hz");
                assert_eq!(up("", aside, hertz, ["x", "y", "z"]), "+x surely", "{aside} deg, {hertz} Hz");
            }
        }
        let hangs = "[rod]\nlength = \"0.4 m\"\nmass = \"0.1 kg\"\nbending_stiffness = \"2 N m^2\"\nbase_angle = \"-90 deg\"\n";
        assert_eq!(up(hangs, 10.0, 4.0, ["x", "y", "z"]), "+x surely");
        // A stiff one does not show gravity in its pace.
        assert!(up("", 10.0, 4.0, ["x", "y", "z"]).ends_with("perhaps"));
    }

    /// A level rod of 1.7 Hz rests 86 mm or more below its clamp. A recording may begin at any turn of its swing.
    #[test]
    fn a_level_rod_that_begins_at_its_lowest_point_is_not_upside_down() {
        for (depth, how) in [(0.07, "+z surely"), (-0.07, "+z perhaps")] {
            let mut text = "t_s,A_x_m,A_y_m,A_z_m\n".to_owned();
            for time in (0..700).map(|k| 0.01 * f64::from(k)) {
                let z = -0.1 + depth * (-0.4 * time).exp() * (std::f64::consts::TAU * 1.7 * time).cos();
                text += &format!("{time:.2},0.4,0.01,{z:.9}\n");
            }
            let recording =
                parse(text.into_bytes(), Path::new("a.csv"), &ReadOptions::default()).expect("a table");
            let text = "[[recording]]\nfile = \"a.csv\"\ntip = \"A\"\ninstants = [\"0 s\"]\n";
            let experiment = Experiment::parse(Path::new("e.toml"), text, &[]).expect("an experiment");
            let cleaned = clean_all(&experiment, vec![recording]).expect("a release");
            let what = cleaned.decisions.into_iter().find(|own| own.key == "up").expect("it is found").what;
            assert!(what.replace(IS_UP, " ").starts_with(how), "{what}");
        }
    }
}
