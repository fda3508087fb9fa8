//! What each of the paper's figures shows, as far as its text says it, and what ours does.

use models::digits::significant;
use schemars::JsonSchema;
use serde::Serialize;

use crate::paper::Pressure;
use crate::picture::{are_recorded, example, in_psi, models};

/// A figure in words.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Words {
    /// Its number in the paper.
    pub number: usize,
    /// What the paper's shows.
    pub paper: String,
    /// What ours shows.
    pub ours: String,
    /// How ours is made differently, or cannot be made.
    pub differs: String,
}

/// All figures in words, from 4 to 9.
pub fn words(all: &[Pressure]) -> Vec<Words> {
    let recorded = are_recorded(all);
    let of = |number: usize, paper: &str, ours: String, [of_recordings, of_runs]: [&str; 2]| Words {
        number,
        paper: paper.to_owned(),
        ours,
        differs: if recorded { of_recordings } else { of_runs }.to_owned(),
    };
    vec![
        of(
            4,
            "Measured paths of the tip and its rests in steps of 10 psi from 5 psi on. The distance to the base grows with the length of the muscle, in smaller steps at high pressure. Out of the plane the tip went by 35.96 mm at most, 18.5 % of the length.",
            paths(all),
            [
                "Ours are recorded, in the plane of the swing; `efam experiment check` shows the way out of it. The paper's paths are not published, so no distance between the two can be given.",
                "Ours are simulated and stay in the plane. The measured paths are not published, so no distance between the two can be told.",
            ],
        ),
        of(
            5,
            "EI from the axial test lies apart from that by bending. That of the beam and that of rods with 8 to 40 nodes agree; both are least at 25 psi. From there to 100 psi EI grows about fourfold: 4.2 times in the table's column of the beam, 3.9 times in that of 32 nodes.",
            stiffness(all),
            [
                "Fitted to recorded rests, as the paper does. Each rest follows from the decay of the last swings, so it does not depend on when the recording ends. The root and the mass are those of the experiment; the paper's root is rod.scheme = \"paper\". An inclined base has no Euler-Bernoulli beam, which is clamped level.",
                "The paper fits measured tips, which are not published. Ours are the rests of runs with the table's EI of 32 nodes, so that rod finds the table again by construction; the beam and the other rods do not. With the root at which the table's two columns agree, rods of 8 and 16 nodes need another EI than that of 32, which the paper does not see; with --set 'rod.scheme=\"consistent\"' rods of 8 to 40 nodes agree, and the column of the beam is missed by a tenth. No one root gives both.",
            ],
        ),
        of(
            6,
            "The tip error after the fit falls as the number of nodes grows, and as EI grows.",
            errors(all),
            [
                "Both errors hold measurement and model. An offset of the marker or of the clamp does not fall with the number of nodes.",
                "The paper's error holds measurement and model; ours is that of the model alone, against the rod of 32 nodes. It may be small where the paper's is not.",
            ],
        ),
        of(
            7,
            "Shapes of the beam and of rods with 4, 8, 16 and 32 nodes over markers at rest. From 20 to 50 psi the beam and the rod of 4 nodes miss the curve; more nodes mend it.",
            shapes(all),
            [
                "Neither places nor number of the paper's markers are published. Ours are those of the experiment; without markers on the body only the tip is compared.",
                "Neither places nor number of the markers are published. In their stead stand points of our simulated rod.",
            ],
        ),
        of(
            8,
            "z(t) at 15 psi with the decay fitted to its upper peaks, and its spectrum. The tip goes beyond straight down, so each swing has a second bump.",
            one_release(all),
            [
                "Of the recorded pressures the one nearest to 15 psi is shown. Where the tip hangs and swings level, x(t) takes the place of z(t).",
                "The damping is assumed, so how fast ours decays says nothing about the muscle. The bump comes from the shape alone.",
            ],
        ),
        of(
            9,
            "Natural frequency: 20 % apart, highest at 10 psi, lowest at 30 to 40 psi, then a linear rise. Damping ratio: about 4.5 times from 5 to 100 psi, two thirds of its highest by 30 psi.",
            swings(all),
            [
                "Frequencies of large swings lie below the first mode, by 1 % at 40 psi. Where they lie above it, the muscle is stiffer in motion than at rest; a moment that resists change has that (efam effects viscoelastic). Only trends of the paper's are published as text.",
                "Missing in ours: the muscle is stiffer in motion than at rest, and more so at high pressure, where it also loses more. A moment that resists change, viscoelastic or frictional, has both (efam effects viscoelastic). Only trends of the paper's are published as text, so no more is claimed.",
            ],
        ),
    ]
}

/// Values over psi, the smallest and the largest of them.
fn ends(all: &[Pressure], of: impl Fn(&Pressure) -> Option<f64>) -> Option<[(f64, f64); 2]> {
    let mut values: Vec<(f64, f64)> = all.iter().filter_map(|own| Some((in_psi(own), of(own)?))).collect();
    values.sort_by(|a, b| a.1.total_cmp(&b.1));
    Some([*values.first()?, *values.last()?])
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

const NOTHING: &str = "Nothing has it.";

fn paths(all: &[Pressure]) -> String {
    let distance = |of: &Pressure| of.tip_at_rest.map(|[x, z]| x.hypot(z));
    let Some([near, far]) = ends(all, distance) else { return NOTHING.to_owned() };
    let lowest = ends(all, |of| of.tip_at_rest.map(|tip| tip[1])).map(|ends| ends[0]);
    let mut text = format!(
        "At rest the tip is {:.0} mm from the base at {} psi, where it is nearest, and {:.0} mm at {} psi.",
        1e3 * near.1,
        near.0,
        1e3 * far.1,
        far.0
    );
    if let Some((psi, z)) = lowest {
        text += &format!(" It hangs lowest at {psi} psi, {:.0} mm below the base.", -1e3 * z);
    }
    text
}

fn stiffness(all: &[Pressure]) -> String {
    let off = |nodes: Option<usize>, place: usize| {
        let share =
            |of: &Pressure| Some((of.fit(nodes)?.bending_stiffness / of.published[place]? - 1.0).abs());
        let values: Vec<f64> = all.iter().filter_map(share).collect();
        let most = values.iter().copied().fold(0.0, f64::max);
        Some([100.0 * median(values)?, 100.0 * most])
    };
    let beam = |of: &Pressure| of.fit(None).map(|fit| fit.bending_stiffness);
    let column = if are_recorded(all) { "the muscle file's own column" } else { "Table 2's own column" };
    let rests = if are_recorded(all) { "the recorded rests" } else { "our rests" };
    let mut text = String::new();
    let grows = |what: &str, [least, most]: [(f64, f64); 2]| {
        format!(
            "The {what} fitted to {rests} has its least EI at {} psi and {} times that at {} psi.",
            least.0,
            significant(most.1 / least.1, 2),
            most.0
        )
    };
    match (ends(all, beam), ends(all, |of| of.fit(Some(32)).map(|fit| fit.bending_stiffness))) {
        (Some(of_beam), _) => text += &grows("beam", of_beam),
        (None, Some(of_rod)) => text += &grows("rod of 32 nodes", of_rod),
        (None, None) => return NOTHING.to_owned(),
    }
    if let Some([middle, worst]) = off(None, 1) {
        text += &format!(
            " The beam misses {column} of the beam by {} % in the median and {} % at most.",
            significant(middle, 2),
            significant(worst, 2)
        );
    }
    if are_recorded(all)
        && let Some([middle, worst]) = off(Some(32), 2)
    {
        text += &format!(
            " 32 nodes: {} % off their column in the median, {} % at most.",
            significant(middle, 2),
            significant(worst, 2)
        );
    }
    for nodes in [4, 8, 16, 40] {
        if let Some([middle, _]) = off(Some(nodes), 2) {
            text +=
                &format!(" {nodes} nodes: {} % off the column of 32, in the median.", significant(middle, 2));
        }
    }
    text
}

fn errors(all: &[Pressure]) -> String {
    let of_nodes = |nodes: Option<usize>| -> Option<f64> {
        median(all.iter().filter_map(|of| of.tip_error(nodes)).collect())
    };
    let mut text = String::from("In the median over the pressures:");
    let recorded = are_recorded(all);
    for nodes in models().filter(|nodes| recorded || *nodes != Some(32)) {
        let Some(error) = of_nodes(nodes) else { continue };
        let name = nodes.map_or("the beam".to_owned(), |nodes| format!("{nodes} nodes"));
        text += &format!(" {name} {} mm,", significant(1e3 * error, 2));
    }
    let falls = all.iter().filter(|of| {
        let rods = [4, 8, 16].map(|nodes| of.tip_error(Some(nodes)));
        matches!(rods, [Some(a), Some(b), Some(c)] if a > b && b > c)
    });
    let by_stiffness = |of: &Pressure| of.tip_error(Some(4));
    let mut text = format!(
        "{}. From 4 to 8 to 16 nodes it falls at {} of {} pressures.",
        text.trim_end_matches(','),
        falls.count(),
        all.len()
    );
    if let Some([least, most]) = ends(all, by_stiffness) {
        text += &format!(" That of 4 nodes is largest at {} psi and least at {} psi.", most.0, least.0);
    }
    text
}

fn shapes(all: &[Pressure]) -> String {
    let off = |nodes: Option<usize>| {
        move |of: &Pressure| of.shapes.iter().find(|shape| shape.nodes == nodes).and_then(|shape| shape.off)
    };
    let what = if are_recorded(all) { "recorded markers" } else { "simulated rod" };
    let mut text = String::new();
    for nodes in [None, Some(4), Some(8), Some(16)] {
        let Some([least, most]) = ends(all, off(nodes)) else { continue };
        let name = nodes.map_or("The beam".to_owned(), |nodes| format!("The rod of {nodes} nodes"));
        text += &format!(
            "{name} is {} mm off the {what} at most, at {} psi, and {} mm at {} psi. ",
            significant(1e3 * most.1, 2),
            most.0,
            significant(1e3 * least.1, 2),
            least.0
        );
    }
    if text.is_empty() { NOTHING.to_owned() } else { text.trim_end().to_owned() }
}

fn one_release(all: &[Pressure]) -> String {
    let Some(of) = example(all) else { return NOTHING.to_owned() };
    let beyond = match of.numbers.beyond_straight_down {
        Some(true) => "The tip goes beyond straight down here, too, and each early swing has the bump.",
        Some(false) => "The tip does not go beyond straight down here.",
        None => "",
    };
    let at = if of.is_recorded() { format!("{} at {} psi. ", of.name, in_psi(of)) } else { String::new() };
    let swing = match (of.numbers.natural_frequency_hz, of.numbers.damping_ratio) {
        (Some(hz), Some(ratio)) => {
            format!(" Natural frequency {hz:.3} Hz, damping ratio {} by the same fit.", significant(ratio, 3))
        }
        _ => String::new(),
    };
    format!("{at}{beyond}{swing}").trim().replace("  ", " ")
}

fn swings(all: &[Pressure]) -> String {
    let Some([slow, fast]) = ends(all, |of| of.numbers.natural_frequency_hz) else {
        return NOTHING.to_owned();
    };
    let mut text = format!(
        "Natural frequency: {:.0} % apart, highest at {} psi ({:.2} Hz), lowest at {} psi ({:.2} Hz).",
        100.0 * (fast.1 / slow.1 - 1.0),
        fast.0,
        fast.1,
        slow.0,
        slow.1
    );
    let ratio = |of: Option<&Pressure>| of.and_then(|of| of.numbers.damping_ratio);
    if let (Some(first), Some(last)) = (ratio(all.first()), ratio(all.last())) {
        text +=
            &format!(" Damping ratio: {:.1} times from the lowest to the highest pressure.", last / first);
    }
    text
}
