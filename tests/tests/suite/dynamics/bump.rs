//! The paper's Figure 8: at 15 psi the tip passes beyond straight down, so that z(t) has a second
//! bump in the trough of a swing. A straight release with the 15 psi row shows it, if large rotations
//! are right. Source: Garbulinski and Wereley (2022), Natural Frequency and Damping.

use efam_core::forward::Run;
use tests::{paper, simulate};

#[test]
fn tip_passes_beyond_straight_down_and_rises_there() {
    let path = simulate(&paper(15.0, 32, &[("rayleigh_mass.alpha", 1.0)]), &Run::release(2.0, 200.0));
    let z = path.tip_z();
    // The first trough lies in the first half second: between its two lowest points z rises.
    let maxima: Vec<usize> =
        (1..100).filter(|&k| z[k] > z[k - 1] && z[k] >= z[k + 1] && z[k] < 0.5 * z[100]).collect();
    assert_eq!(maxima.len(), 1, "one bump in the first trough, at {maxima:?}");
    let bump = maxima[0];
    let lowest = z[..bump].iter().chain(&z[bump..100]).copied().fold(0.0, f64::min);
    assert!(z[bump] - lowest > 0.002, "the tip rises by {} m", z[bump] - lowest);
    let angle = |k: usize| path.state(k).q.last().copied().expect("the end body's angle").to_degrees();
    assert!(angle(bump) < -90.0, "the end fitting points back: {} degrees", angle(bump));
}
