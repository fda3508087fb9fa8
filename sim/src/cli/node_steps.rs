//! Budgets of work on the command line: node steps, and about how long they take here.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use efam_core::example::muscle_at_15_psi;
use efam_core::forward::{FAST_TOLERANCE, Run, forward};
use efam_core::work::Work;
use models::quantity::Quantity;

/// A budget in node steps, such as `2e9`.
pub fn parse(text: &str) -> Result<u64, String> {
    // A time was admitted before.
    if Quantity::parse(text).is_ok_and(|quantity| quantity.to("s").is_ok() && quantity.to("").is_err()) {
        return Err(format!(
            "it counts node steps (nodes times steps of the integrator), so that every machine gives the same answer; \
             write a number such as 2e9, or --time-limit \"{text}\" to end the search by the clock"
        ));
    }
    match text.trim().parse::<f64>() {
        Ok(node_steps) if (1.0..=1e18).contains(&node_steps) => Ok(node_steps as u64),
        _ => Err("it must be a number of node steps, 1 to 1e18, such as 2e9".to_owned()),
    }
}

/// A time in words.
pub fn duration(time: Duration) -> String {
    match time.as_secs_f64() {
        seconds if seconds < 60.0 => format!("{} s", models::digits::significant(seconds, 2)),
        seconds if seconds < 7200.0 => format!("{} min", models::digits::significant(seconds / 60.0, 2)),
        seconds => format!("{} h", models::digits::significant(seconds / 3600.0, 2)),
    }
}

/// Derivatives and tolerance as in a fit.
fn fixed_work() -> (models::model::Model, Run, Work) {
    let model = muscle_at_15_psi();
    let work = Work::limited(u64::MAX);
    let sensitivities = ["rod.bending_stiffness", "rod.mass"];
    let sensitivities = sensitivities.iter().filter_map(|path| model.index(path).ok()).collect();
    let run =
        Run { sensitivities, tolerance: FAST_TOLERANCE, work: work.clone(), ..Run::release(0.5, 100.0) };
    (model, run, work)
}

/// About the time that one thread takes here: the fastest of three runs of a fixed piece of work, which others may slow
/// down. For messages only.
pub fn time_here(node_steps: u64) -> Option<Duration> {
    let (model, run, work) = fixed_work();
    let timed = |_| {
        let (begin, before) = (Instant::now(), work.node_steps());
        forward(&model, &run, &mut |_| ControlFlow::Continue(())).ok()?;
        Some(begin.elapsed().as_secs_f64() / (work.node_steps() - before).max(1) as f64)
    };
    let fastest = (0..3).filter_map(timed).fold(f64::INFINITY, f64::min);
    Duration::try_from_secs_f64(fastest * node_steps as f64).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_a_number_and_a_time_is_refused_with_what_to_write() {
        assert_eq!(["2e9", "1", " 1500000 "].map(|text| parse(text).unwrap()), [2_000_000_000, 1, 1_500_000]);
        let of_time = parse("3 min").unwrap_err();
        assert!(of_time.contains("such as 2e9") && of_time.contains("--time-limit \"3 min\""), "{of_time}");
        for wrong in ["0", "-1e9", "1e19", "nan", "many", "3 mm", ""] {
            assert!(parse(wrong).unwrap_err().contains("1 to 1e18"), "{wrong}");
        }
    }

    /// Twice the work takes twice the estimate: it is of one speed, whatever that is.
    #[test]
    fn the_estimate_is_of_some_speed() {
        assert!(time_here(1_000_000).is_some_and(|time| time > Duration::ZERO));
    }
}
