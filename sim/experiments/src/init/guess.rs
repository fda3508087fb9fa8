//! Which markers of a recording are its tip, its base and its body, by how far they move.

use std::fmt::Write;

use efam_core::quantile::quantile;
use efam_recordings::Recording;
use efam_store::escape::{escaped, toml_string};
use nalgebra::{Matrix3, Vector3};

use crate::cleaning::distance;

/// Motion of base markers in that of the most moving one, at most, in the time of a swing: a camera or a table may drift.
const STILL: f64 = 0.04;
/// The same of markers that are named like a base.
const STILL_BY_NAME: f64 = 0.25;
/// Names of markers that do not move.
const BASES: [&str; 6] = ["base", "clamp", "root", "ground", "fixed", "wall"];
/// Share of the tip's whole motion: the way that it goes within a swing at least, and that a base drifts at most.
const HALF: f64 = 0.5;
/// Motion of tip markers, likewise, at least.
const TIP: f64 = 0.8;
/// By how much the distance of two markers of one body may vary, in the motion of the tip.
const RIGID: f64 = 0.1;
/// Share of a marker's motion that follows that of the tip, at least, on one rod. In its second mode a rod moves less than that
/// for part of the time only.
const FOLLOWS: f64 = 0.5;

/// What the markers of a recording seem to be.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// Most moving, and as one body.
    pub tip: Vec<String>,
    /// Least moving.
    pub base: Vec<String>,
    /// All between, with their share of the way from base to tip.
    pub body: Vec<(String, f64)>,
    /// Those that move otherwise than the tip does, as those of another rod, and what is still beside them.
    pub others: Vec<String>,
    /// How far each marker moves, m, in the order of the recording.
    pub moves: Vec<(String, f64)>,
}

/// Identifies tip, base and body by how much they move; nothing if no marker is seen.
pub fn guess(recording: &Recording) -> Option<Guess> {
    let moves: Vec<f64> = recording.markers.iter().map(|marker| reach(&marker.position)).collect();
    let most =
        (0..moves.len()).max_by(|&a, &b| moves[a].total_cmp(&moves[b])).filter(|&k| moves[k] >= 0.0)?;
    let path = |k: usize| &recording.markers[k].position;
    let of_tip = |k: usize| {
        k == most || (moves[k] > TIP * moves[most] && spread(path(k), path(most)) < RIGID * moves[most])
    };
    let is_tip: Vec<bool> = (0..moves.len()).map(of_tip).collect();
    let lag = lag(path(most), HALF * moves[most]);
    let within = |k: usize| Some(moves[most] * pace(path(k), lag?)? / pace(path(most), lag?)?);
    let swings: Vec<f64> = (0..moves.len())
        .map(|k| {
            within(k).filter(|_| moves[k] < HALF * moves[most]).map_or(moves[k], |way| way.min(moves[k]))
        })
        .collect();
    let is_base = |k: usize| {
        let name = recording.markers[k].name.to_lowercase();
        let limit = if BASES.iter().any(|base| name.contains(base)) { STILL_BY_NAME } else { STILL };
        !is_tip[k] && moves[k] >= 0.0 && swings[k] < limit * moves[most]
    };
    let middles: Vec<[f64; 3]> = (0..moves.len()).map(|k| middle(path(k))).collect();
    let is_apart: Vec<bool> = (0..moves.len())
        .map(|k| {
            let moves = !is_tip[k] && !is_base(k) && moves[k] > STILL * moves[most];
            moves && follows(path(k), path(most)) < FOLLOWS
        })
        .collect();
    // What is still belongs to the rod whose marker is nearest.
    let is_beside = |k: usize| {
        let apart = (0..moves.len()).filter(|&j| is_apart[j]);
        apart.fold(f64::INFINITY, |near, j| near.min(distance(middles[k], middles[j])))
            < distance(middles[k], middles[most])
    };
    let is_other: Vec<bool> = (0..moves.len()).map(|k| is_apart[k] || is_base(k) && is_beside(k)).collect();
    let is_base: Vec<bool> = (0..moves.len()).map(|k| is_base(k) && !is_other[k]).collect();
    let those = |is: &[bool]| -> Vec<usize> { (0..moves.len()).filter(|&k| is[k]).collect() };
    let (tip, base) = (those(&is_tip), those(&is_base));
    let place = |of: &[usize]| -> [f64; 3] {
        let first: Vec<[f64; 3]> =
            of.iter().filter_map(|&k| path(k).iter().flatten().next().copied()).collect();
        std::array::from_fn(|c| first.iter().map(|at| at[c]).sum::<f64>() / first.len().max(1) as f64)
    };
    let (from, to) = (place(&base), place(&tip));
    let share = |k: usize| (distance(place(&[k]), from) / distance(to, from).max(1e-9)).clamp(0.0, 1.0);
    let is_body = |k: &usize| moves[*k] >= 0.0 && !is_tip[*k] && !is_base[*k] && !is_other[*k];
    let mut body: Vec<(usize, f64)> = (0..moves.len()).filter(is_body).map(|k| (k, share(k))).collect();
    body.sort_by(|a, b| a.1.total_cmp(&b.1));
    let name = |k: usize| recording.markers[k].name.clone();
    Some(Guess {
        tip: tip.iter().map(|&k| name(k)).collect(),
        base: base.iter().map(|&k| name(k)).collect(),
        body: body.into_iter().map(|(k, share)| (name(k), share)).collect(),
        others: those(&is_other).into_iter().map(name).collect(),
        moves: (0..moves.len()).map(|k| (name(k), moves[k])).collect(),
    })
}

/// Writes the keys of the markers, as they seem to be.
pub(super) fn write(out: &mut String, recording: &Recording) {
    let list = |names: &[String]| match names {
        [only] => toml_string(only),
        all => format!("[{}]", all.iter().map(|name| toml_string(name)).collect::<Vec<_>>().join(", ")),
    };
    let Some(guess) = guess(recording) else {
        *out += "tip = \"?\"   # FILL IN: no marker is seen in this file\n";
        return;
    };
    let moves: Vec<_> =
        guess.moves.iter().map(|(name, m)| format!("{} {:.1}", escaped(name), 1e3 * m)).collect();
    let _ = writeln!(out, "# how far each marker moves, mm: {}", moves.join(", "));
    let _ = writeln!(out, "tip = {}   # GUESS: what moves most, as one body", list(&guess.tip));
    if !guess.others.is_empty() {
        let _ = writeln!(
            out,
            "# not used: {}   # GUESS, perhaps of another rod: it moves otherwise than the tip, and needs a\n\
             \x20                 # [[recording]] of its own, with its own tip, base and body",
            list(&guess.others)
        );
    }
    if !guess.base.is_empty() {
        let _ = writeln!(out, "base = {}   # GUESS: what hardly moves", list(&guess.base));
    } else {
        *out +=
            "# base = [\"…\"]   # none found: a base at rest is assumed, and the clamp at the file's origin\n"
    }
    for (k, (name, share)) in guess.body.iter().enumerate() {
        let open = if k == 0 {
            "body = [   # GUESS: by what they move; `at` by distance, FILL IN, such as \"120 mm\"\n"
        } else {
            ""
        };
        let close = if k + 1 == guess.body.len() { "]\n" } else { "" };
        let _ = write!(out, "{open}  {{ marker = {}, at = {share:.2} }},\n{close}", toml_string(name));
    }
}

/// Distance from its median place within which a marker is 98 % of the time, m; −1 if it is never seen.
fn reach(path: &[Option<[f64; 3]>]) -> f64 {
    let middle = middle(path);
    quantile(path.iter().flatten().map(|at| distance(*at, middle)).collect(), 0.98).unwrap_or(-1.0)
}

/// Samples within which a marker goes some way, 2 % of the time; nothing if it never does.
fn lag(path: &[Option<[f64; 3]>], way: f64) -> Option<usize> {
    (0..).map(|power| 1 << power).take_while(|lag| *lag < path.len()).find(|lag| pace(path, *lag) > Some(way))
}

/// Distance that a marker moves in some samples, 98 % of the time at most, m.
fn pace(path: &[Option<[f64; 3]>], lag: usize) -> Option<f64> {
    let ways = path.iter().zip(&path[lag..]).filter_map(|(from, to)| Some(distance((*from)?, (*to)?)));
    quantile(ways.collect(), 0.98)
}

/// Median place of a marker, m.
fn middle(path: &[Option<[f64; 3]>]) -> [f64; 3] {
    let of = |c: usize| path.iter().flatten().map(|at| at[c]).collect();
    std::array::from_fn(|c| quantile(of(c), 0.5).unwrap_or_default())
}

/// Share of a marker's motion that is linear in the place of the tip; 1 where they are never seen together.
fn follows(path: &[Option<[f64; 3]>], tip: &[Option<[f64; 3]>]) -> f64 {
    let both =
        path.iter().zip(tip).filter_map(|(own, tip)| Some((Vector3::from((*own)?), Vector3::from((*tip)?))));
    let both: Vec<_> = both.collect();
    let count = both.len().max(1) as f64;
    let mean =
        both.iter().fold([Vector3::zeros(); 2], |[own, tip], at| [own + at.0 / count, tip + at.1 / count]);
    let (mut all, mut by_tip, mut of_tip) = (0.0, Matrix3::zeros(), Matrix3::zeros());
    for (own, tip) in &both {
        let (own, tip) = (own - mean[0], tip - mean[1]);
        all += own.norm_squared();
        by_tip += tip * own.transpose();
        of_tip += tip * tip.transpose();
    }
    // What does not move along an axis explains nothing there.
    let Ok(inverse) = of_tip.pseudo_inverse(1e-6 * of_tip.norm()) else { return 1.0 };
    if all > 0.0 { (by_tip.transpose() * inverse * by_tip).trace() / all } else { 1.0 }
}

/// By how much the distance of two markers varies, 96 % of the time, m.
fn spread(a: &[Option<[f64; 3]>], b: &[Option<[f64; 3]>]) -> f64 {
    let both = a.iter().zip(b).filter_map(|(a, b)| Some(((*a)?, (*b)?)));
    let apart: Vec<f64> = both.map(|(a, b)| distance(a, b)).collect();
    let between = quantile(apart.clone(), 0.98).zip(quantile(apart, 0.02));
    between.map_or(f64::INFINITY, |(high, low)| high - low)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use efam_recordings::{ReadOptions, parse};

    use super::*;

    /// Markers that only drift, by a fifth of what the tip moves, are a base; one that swings by less than that is on the rod.
    #[test]
    fn a_base_that_drifts_is_a_base() {
        let names =
            ["a", "b", "m", "tip"].map(|name| ["x", "y", "z"].map(|axis| format!(",{name}_{axis}_mm")));
        let mut text = format!("t_s{}\n", names.concat().concat());
        for time in (0..700).map(|k| 0.01 * f64::from(k)) {
            let (drift, since) = (3.0 * time, (time - 1.0).max(0.0));
            let z = 70.0 * ((-0.4 * since).exp() * (10.0 * since).cos() - 1.0);
            text += &format!("{time:.2},0,{drift},0,10,{drift},0,100,{drift},{},300,{drift},{z}\n", 0.15 * z);
        }
        let recording =
            parse(text.into_bytes(), Path::new("a.csv"), &ReadOptions::default()).expect("a table");
        let guess = guess(&recording).expect("markers");
        assert_eq!((guess.base, guess.tip), (vec!["a".to_owned(), "b".to_owned()], vec!["tip".to_owned()]));
        assert_eq!(guess.body.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["m"]);
    }
}
