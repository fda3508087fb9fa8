use super::*;
use crate::diagnose::verdict::Member;
use crate::diagnose::verdict::Shares;

fn gap(release: &str, held_out: bool, before: f64, after: f64) -> Gap {
    let release = release.to_owned();
    let distance = |over_noise: f64| 0.3 * std::f64::consts::SQRT_2 * over_noise;
    Gap {
        release,
        held_out,
        before_mm: distance(before),
        after_mm: distance(after),
        before,
        after,
        noise_mm: 0.3,
    }
}

fn evidence(effect: &str, kept: Option<f64>) -> Evidence {
    Evidence {
        round: 1,
        effect: effect.to_owned(),
        of_each_pressure: false,
        of_first_swings: false,
        tried: Vec::new(),
        score: 30.0,
        predicted_decrease: 900.0,
        realised_decrease: kept,
        strength: 1.0,
        held_out_decrease: None,
        rejected: None,
    }
}

fn misfit(what: Wrong, amplitudes: [f64; 2], size_mm: f64) -> Misfit {
    Misfit {
        what,
        amplitudes,
        per_cycle: -0.02,
        standard_error: 1e-3,
        size_mm,
        cycles: [4.0, 0.0],
        pressures_pa: vec![1.034e5, 2.758e5],
        pressures_there_pa: vec![1.034e5, 2.758e5],
    }
}

fn drag() -> Diagnosis {
    let value = ParameterValue {
        name: "drag_coefficient".to_owned(),
        unit: String::new(),
        of: None,
        value: 1.1,
        interval_95: Some([1.0, 1.2]),
    };
    // Squares beyond noise: 8 of which 7.44 go.
    let gap = vec![gap("a", false, 3.0, 1.56f64.sqrt()), gap("b", true, 2.5, 1.01)];
    Diagnosis {
        verdict: Verdict::Named,
        effects: vec![Added { effect: "air_drag".to_owned(), parameters: vec![value] }],
        shares: Some(Shares::of(&gap)),
        gap,
        evidence: vec![
            evidence("air_drag", Some(1000.0)),
            evidence("creep", None),
            evidence("braid_friction", Some(441.0)),
        ],
        misfits: vec![misfit(Wrong::LosesEnergyTooSlowly, BANDS[0], 1.0)],
        ..Diagnosis::default()
    }
}

#[test]
fn a_named_effect_is_told_with_all_that_stands_behind_it() {
    assert_eq!(
        summary(&drag()),
        "Air drag on the body is missing: drag coefficient 1.10 (95 % interval 1.00 to 1.20). The gap between simulation \
         and recordings falls from 1.3 to 0.53 mm.\n\
         It explains 93 % of the residual beyond noise, and all on held-out releases, where the gap falls from 1.1 to \
         0.43 mm.\n\
         The simulation loses energy too slowly at large swings (above 40 % of the largest amplitude), at all \
         pressures, in the first 4 cycles.\n\
         Braid friction, the next best, would explain 41 %."
    );
}

/// Each part is left out alone where there is nothing to say it by.
#[test]
fn what_no_number_supports_is_not_said() {
    let bare =
        Diagnosis { evidence: Vec::new(), misfits: Vec::new(), gap: Vec::new(), shares: None, ..drag() };
    assert_eq!(
        summary(&bare),
        "Air drag on the body is missing: drag coefficient 1.10 (95 % interval 1.00 to 1.20)."
    );
    // A gap of noise alone has no share.
    let with = |gap: Vec<Gap>| Diagnosis { shares: Some(Shares::of(&gap)), gap, ..drag() };
    let quiet = with(vec![gap("a", false, 1.005, 1.0)]);
    assert!(!summary(&quiet).contains("explain"), "{}", summary(&quiet));
    let worse = with(vec![gap("a", false, 3.0, 1.0), gap("b", true, 1.2, 1.4)]);
    assert!(summary(&worse).contains(
        "all of the residual beyond noise, and nothing on held-out releases, where the gap rises from 0.51 to 0.59 mm."
    ));
    let mut one = drag();
    one.misfits[0].pressures_there_pa = vec![1.034e5];
    one.misfits[0].pressures_pa = vec![1.034e5];
    assert!(!summary(&one).contains("pressures"), "one pressure is not all: {}", summary(&one));
    let mut some = drag();
    some.misfits[0].pressures_pa = vec![2.758e5];
    assert!(summary(&some).contains("most clearly at 276 kPa"), "{}", summary(&some));
    let mut held = drag();
    held.effects[0].parameters[0].interval_95 = None;
    assert!(summary(&held).contains("drag coefficient 1.10 (not fitted)."), "{}", summary(&held));
    let mut many = drag();
    many.effects[0].parameters = vec![many.effects[0].parameters[0].clone(); 4];
    assert!(summary(&many).starts_with("Air drag on the body is missing. The gap"), "{}", summary(&many));
}

#[test]
fn misfits_of_two_kinds_are_told_and_small_ones_are_not() {
    let small = misfit(Wrong::LosesEnergyTooFast, BANDS[2], 0.5);
    let mut two = Diagnosis { misfits: vec![misfit(Wrong::SwingsTooSlowly, BANDS[1], 1.0), small], ..drag() };
    two.misfits[0].cycles = [3.0, 4.0];
    assert!(
        summary(&two).contains(
            "\nThe simulation swings too slowly at middle swings (15 to 40 % of the largest amplitude), at all \
             pressures, from cycle 5 to 7; it loses energy too fast at small swings (below 15 % of the largest \
             amplitude).\n"
        ),
        "{}",
        summary(&two)
    );
    two.misfits[1].size_mm = 0.1;
    assert!(!summary(&two).contains("too fast"));
}

#[test]
fn a_class_says_who_is_in_it_and_what_to_record() {
    let member = Member { effect: "tip_drag".to_owned(), behind: 3.0, distance: 1.2 };
    let what = "the same releases repeated from 25 degrees below".to_owned();
    let class = Diagnosis {
        verdict: Verdict::Class,
        members: vec![member],
        separating_experiment: Some(Separation { what, distance: 7.24, distance_now: 1.2 }),
        ..drag()
    };
    let words = summary(&class);
    assert!(words.contains(
        "Air drag on the body is missing, or an effect that these recordings cannot separate from it (tip drag): drag"
    ));
    assert!(words.ends_with(
        "To separate them, record the same releases repeated from 25 degrees below: by simulation, this raises the distance of the nearest two from 1.2 to 7.2 standard deviations."
    ));
    let next = evidence("tip_drag", Some(990.0));
    let class = Diagnosis { evidence: [&class.evidence[..], &[next]].concat(), ..class.clone() };
    assert!(summary(&class).contains("Braid friction, the next best"), "a member is none: {words}");
}

#[test]
fn two_effects_are_plural_and_have_no_next_best() {
    let mut two = drag();
    two.effects.push(Added { effect: "creep".to_owned(), parameters: Vec::new() });
    let words = summary(&two);
    assert!(words.contains("Air drag on the body and creep are missing: drag coefficient"), "{words}");
    assert!(words.contains("They explain 93 %") && !words.contains("next best"), "{words}");
}

#[test]
fn an_unknown_is_described_and_nothing_is_just_that() {
    let shape = Shape {
        round: 2,
        what: "the swing's third harmonic".to_owned(),
        score: 12.0,
        threshold: 4.0,
        at_amplitude: 0.37,
        size_mm: 0.213,
    };
    let unknown = Diagnosis { verdict: Verdict::Unknown, shapes: vec![shape], ..drag() };
    let words = summary(&unknown);
    assert!(
        words.starts_with(
            "Something is missing that no effect of the catalogue explains. The gap between simulation and recordings \
             falls from 1.3 to 0.53 mm.\nThe simulation loses"
        )
    );
    assert!(
        words.contains("Air drag on the body describes 93 % of it, and need not be its cause."),
        "{words}"
    );
    assert!(
        words.contains("residual pattern: the swing's third harmonic, 0.21 mm at the tip, mostly at 37 %")
    );
    let nothing =
        Diagnosis { gap: vec![gap("a", false, 1.02, 1.02)], misfits: drag().misfits, ..Diagnosis::default() };
    assert_eq!(
        summary(&nothing),
        "Nothing is missing that these recordings could show.\n\
         No effect of the catalogue lowers the gap by more than noise and repeatability explain.\n\
         The residual is 1.02 times the noise; 1 is noise alone."
    );
}

/// What no effect explains is told by its terms, and called what it is.
#[test]
fn a_description_is_told_term_by_term() {
    let term = |name: &str, unit: &str, value: f64| ParameterValue {
        name: name.to_owned(),
        unit: unit.to_owned(),
        of: None,
        value,
        interval_95: Some([0.9 * value, 1.1 * value]),
    };
    let parameters = vec![term("cube", "m^2", 1.2e-3), term("rate_sign", "1/m", -0.03)];
    let moment = Added { effect: "latent_moment".to_owned(), parameters };
    let description = Some(Description { moment, share: 0.83, decrease: 900.0 });
    let unknown = Diagnosis { verdict: Verdict::Unknown, description, ..drag() };
    let words = summary(&unknown);
    let due = "A description, not a cause: a moment at every bend, over EI with the cube of the curvature \
               (0.00120 m^2) and with the sign of the rate of curvature (-0.0300 1/m), would explain 83 % of the residual.";
    assert!(words.contains(due), "{words}");
}

/// What contradicts the setup comes after the answer, or is a part of it where it explains as much as the effect.
#[test]
fn contradictions_are_said() {
    let contradiction = |deviations: f64| Contradiction {
        parameter: "rod.bending_stiffness".to_owned(),
        value: 7e-5,
        unit: "N m^2".to_owned(),
        deviations,
    };
    let found = |verdict, deviations: f64| {
        summary(&Diagnosis { verdict, contradictions: vec![contradiction(deviations)], ..drag() })
    };
    let told = "rod.bending_stiffness = 0.0000700 N m^2 is 9 standard deviations from its prior";
    let unknown = found(Verdict::Unknown, 9.0);
    assert!(unknown.contains(&format!("or a stated value is wrong: {told}. Check it first.")), "{unknown}");
    let incomplete = found(Verdict::Incomplete, 9.0);
    assert!(incomplete.contains(&format!("A stated value may be wrong instead: {told}.")), "{incomplete}");
    let named = found(Verdict::Named, 9.0);
    assert!(named.contains(&format!("\nA stated value may be wrong: {told}.")), "{named}");
    let either = found(Verdict::Class, 9.0);
    let first = either.lines().next().expect("a line");
    assert!(
        first.contains(&format!(" 1.20). Or a stated value is wrong: {told}; check it first. The gap")),
        "{either}"
    );
    assert_eq!(either.matches(told).count(), 1, "{either}");
    let misstated = found(Verdict::Misstated, 9.0);
    assert!(misstated.starts_with(&format!("A stated value is wrong: {told}. The gap")), "{misstated}");
}
