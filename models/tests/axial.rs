//! Rods for which no axial stiffness is given: they hang as long as they are, swing as closed forms say, and no
//! vibration along them is taken for one across.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use models::effects::Rod;
use models::model::{AxialSource, Model, ModelSpec};
use models::statics::{Mode, equilibrium, modes};
use models::system::System;

const GRAVITY: f64 = 9.81;

/// A rod that hangs, with a point mass at its end.
fn hanging(rod: Rod<f64>, payload: f64) -> Model {
    let spec = ModelSpec { base_angle: -FRAC_PI_2, release_angle: -FRAC_PI_2, ..ModelSpec::of(rod) };
    Model::new(&spec.with(&[("gravity.acceleration", GRAVITY), ("payload.mass", payload)])).unwrap()
}

/// How deep the end hangs, m, and the slowest modes.
fn at_rest(model: &Model, count: usize) -> (f64, Vec<Mode>) {
    let rest = equilibrium(model, None).unwrap();
    let (end, _) = System::at_rest(model).observed_tip(&rest.q, &vec![0.0; rest.q.len()]);
    (-end[1], modes(model, &rest, count).unwrap())
}

/// A plastic filament of 1 m, 1 g, with 50 g at its end.
fn filament() -> Rod<f64> {
    Rod::plain(1.0, 1e-3, 1.47e-4)
}

/// Frequencies of a filament, Hz, Rayleigh's way, each to a per cent. Near its clamp it bends within `λ = √(EI/T)`, so
/// that it is shorter by that. It is a pendulum, then a string between the clamp and a mass that hardly moves: with `μ` the
/// mass of the string over that of the end, `k L = π + μ/π`.
fn filament_frequencies(payload: f64) -> [f64; 2] {
    let Rod { length, mass, bending_stiffness, .. } = filament();
    let tension = (payload + 0.5 * mass) * GRAVITY;
    let length = length - (bending_stiffness / tension).sqrt();
    let pendulum = (GRAVITY * (payload + mass / 2.0) / ((payload + mass / 3.0) * length)).sqrt();
    let string = (PI + mass / payload / PI) / length * (tension / mass).sqrt();
    [pendulum, string].map(|omega| omega / TAU)
}

fn assert_filament(modes: &[Mode], payload: f64) {
    for (mode, expected) in modes.iter().zip(filament_frequencies(payload)) {
        let found = mode.angular_frequency / TAU;
        assert!((found / expected - 1.0).abs() < 0.01, "{found} Hz, expected {expected} Hz");
    }
}

#[test]
fn a_filament_hangs_and_swings_as_long_as_it_is() {
    let model = hanging(filament(), 0.05);
    assert_eq!(model.axial_source, AxialSource::Unstretched);
    let (depth, modes) = at_rest(&model, 2);
    assert!((depth - 1.0).abs() < 1.1e-4, "{depth} m");
    assert_filament(&modes, 0.05);
}

/// `EA = 16 EI / d²` of a solid round section; the end hangs by the stretch of the payload and of half the rod lower.
#[test]
fn a_diameter_gives_the_axial_stiffness_of_a_round_section() {
    let (diameter, payload) = (1e-3, 0.05);
    let model = hanging(Rod { diameter, ..filament() }, payload);
    let due = 16.0 * 1.47e-4 / (diameter * diameter);
    assert_eq!(model.axial_source, AxialSource::RoundSection);
    assert!((model.rod().axial_stiffness / due - 1.0).abs() < 1e-12);
    let (depth, modes) = at_rest(&model, 2);
    let stretch = (payload + 0.5e-3) * GRAVITY / due;
    assert!(((depth - 1.0) / stretch - 1.0).abs() < 1e-3, "{depth} m");
    assert_filament(&modes, payload);
}

/// A strip of card whose width is given as its diameter, for the air drag: a round section of that width and EI would
/// stretch by 6 %.
#[test]
fn a_diameter_that_is_no_section_is_said() {
    let strip = Rod { diameter: 50.8e-3, ..Rod::plain(0.2159, 1.535e-3, 6.5e-5) };
    let model = hanging(strip, 1e-3);
    assert_eq!(model.axial_source, AxialSource::Unstretched);
    let (depth, _) = at_rest(&model, 1);
    assert!((depth / 0.2159 - 1.0).abs() < 1.1e-4, "{depth} m");
    let warning = model.axial_warning().unwrap();
    assert!(warning.contains("rod.diameter = 50.8 mm") && warning.contains("6.2 %"), "{warning}");
    assert_eq!(hanging(filament(), 0.05).axial_warning(), None);
}

/// Whatever axial stiffness is given, no bounce is among the modes. Expected: those of the filament as long as it is when
/// it is stretched; the bounce of 50 g on 5.88 N lies between the two, at 1.72 Hz.
#[test]
fn a_vibration_along_the_rod_is_no_bending_mode() {
    let soft = hanging(Rod { axial_stiffness: 5.88, ..filament() }, 0.05);
    let (depth, modes) = at_rest(&soft, 3);
    let stretch = depth - 1.0;
    assert!((stretch - 0.084).abs() < 1e-3, "{depth} m");
    let string = filament_frequencies(0.05)[1] / (1.0 + stretch).sqrt();
    let found = modes[1].angular_frequency / TAU;
    assert!((found / string - 1.0).abs() < 0.01, "{found} Hz, expected {string} Hz");
    assert_eq!(modes.len(), 3);
    assert!(modes.iter().all(|mode| mode.stretch_share < 0.1));
}

/// A chain, which hardly resists bending: `ω = j/2 √(g/L)` with the zeros `j` of the Bessel function J₀. Tolerance: the
/// stretch, and the bending stiffness, which holds `√(EI/T)`
/// of 1 mm near the clamp, and the mesh of 31 edges.
#[test]
fn a_chain_swings_as_bessel_functions_say() {
    let model = hanging(Rod::plain(0.5, 0.1, 1e-6), 0.0);
    let (depth, modes) = at_rest(&model, 2);
    assert!((depth / 0.5 - 1.0).abs() < 1.1e-4, "{depth} m");
    for (mode, zero) in modes.iter().zip([2.404_825_557_7, 5.520_078_110_3]) {
        let due = 0.5 * zero * (GRAVITY / 0.5f64).sqrt();
        assert!((mode.angular_frequency / due - 1.0).abs() < 3e-3, "{}, due {due}", mode.angular_frequency);
    }
}

/// A rod that is stiff for its load keeps the axial stiffness of a length of fifty diameters, and one that is given stays.
#[test]
fn a_stiff_rod_has_that_of_a_slender_one() {
    let rod = Rod::plain(0.3, 0.03, 0.05);
    let stiffness = |rod: Rod<f64>| hanging(rod, 0.01).rod().axial_stiffness;
    assert!((stiffness(rod) / (4e4 * 0.05 / 0.09) - 1.0).abs() < 1e-12);
    assert_eq!(stiffness(Rod { axial_stiffness: 237.0, ..rod }), 237.0);
}
