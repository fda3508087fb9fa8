//! What the paper's text says of its measurements, beside a simulated set of its pressures.

use crate::simulated::Member;

/// The trends that the paper measured beside those simulated, and what would make up the difference.
pub fn beside_the_paper(done: &[Member]) -> String {
    let at = |member: &Member| Some((member.summary.as_paper()[0]?, member.pressure?));
    let mut swings: Vec<_> = done.iter().filter_map(at).collect();
    swings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let psi = |pascal: f64| (pascal / 6894.757).round();
    let ours = match swings[..] {
        [slow, .., fast] => format!(
            "{:.2} to {:.2} Hz, {:.0} % apart; highest at {} psi, lowest at {} psi",
            slow.0,
            fast.0,
            100.0 * (fast.0 / slow.0 - 1.0),
            psi(fast.1),
            psi(slow.1)
        ),
        _ => "no swing".to_owned(),
    };
    let ratio = |member: &Member| member.summary.as_paper()[2];
    let damping = match (done.first().and_then(ratio), done.last().and_then(ratio)) {
        (Some(first), Some(last)) => format!("from {first:.3} to {last:.3}, {:.1} times", last / first),
        _ => "unknown".to_owned(),
    };
    let has_branch =
        |member: &Member| member.summary.parameters.contains_key("effects.viscoelastic.branch_stiffness");
    let says = if done.iter().any(has_branch) { MADE } else { MISSING };
    format!(
        "simulated frequency: {ours}
measured (Garbulinski and Wereley 2022): 20 % apart; highest at 10 psi, lowest at 30 to 40 psi, \
rising in a straight line above
simulated damping ratio, lowest to highest pressure: {damping}
measured: about 4.5 times, two thirds of the highest by 30 psi
{says}
"
    )
}

/// Of the static muscle.
const MISSING: &str = "\
Missing here: the muscle is stiffer in motion than at rest, and more so at high pressure, where it also loses more.
A bending moment that resists change, viscoelastic or frictional, has both; see efam effects viscoelastic. The muscle
garbulinski-2022-in-motion has such a branch.";

/// Of a muscle with a branch.
const MADE: &str = "\
A viscoelastic branch acts here. That of garbulinski-2022-in-motion was made from these trends, and is no evidence for them.";
