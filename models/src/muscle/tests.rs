use super::*;
use crate::quantity::Unit;

const REFUSED: Extrapolation = Extrapolation::Refused;

fn published() -> Muscle {
    Muscle::built_in("garbulinski-2022").unwrap_or_else(|error| panic!("{error}"))
}

fn psi(pressure: f64) -> f64 {
    pressure * Unit::parse("psi").unwrap().scale
}

/// The built-in file with one piece of it exchanged.
fn altered(piece: &str, by: &str) -> Result<Muscle, MuscleError> {
    let text = BUILT_IN[0].1;
    assert!(text.contains(piece), "{piece}");
    Muscle::from_toml(&text.replacen(piece, by, 1))
}

fn error(piece: &str, by: &str) -> String {
    altered(piece, by).unwrap_err().to_string()
}

#[test]
fn every_built_in_muscle_has_its_name() {
    for (name, _) in BUILT_IN {
        assert_eq!(&Muscle::built_in(name).unwrap().name, name);
    }
}

/// Table 1 of the paper.
#[test]
fn constants_are_those_of_the_paper() {
    let muscle = published();
    assert_eq!(muscle.rest.length, 6.69 * 0.0254);
    assert_eq!(muscle.rest.mass_per_length, 0.14227);
    assert_eq!(muscle.rest.inner_diameter, Some(0.97 * 0.0254));
    assert_eq!(muscle.rest.outer_diameter, Some(1.07 * 0.0254));
    assert!((muscle.rest.braid_angle.unwrap() - 12.5_f64.to_radians()).abs() < 1e-15);
    assert!((muscle.end_fitting.mass - 0.05492).abs() < 1e-15);
    assert_eq!(muscle.end_fitting.center_of_mass, 0.662 * 0.0254);
    // Estimated, as its file says: a uniform cylinder as thick as the muscle, its middle at 0.662 in.
    let (radius, length) = (0.5 * 1.07 * 0.0254, 2.0 * 0.662 * 0.0254);
    let cylinder = 0.05492 * (3.0 * radius * radius + length * length) / 12.0;
    assert!((muscle.end_fitting.rotary_inertia / cylinder - 1.0).abs() < 5e-3, "{cylinder}");
    assert_eq!(muscle.gravity, 9.81);
}

/// Sums over the columns of Table 2, plain and weighted by the row's number, made from the paper's
/// text: a wrong digit changes both, two rows exchanged the second.
#[test]
fn table_is_that_of_the_paper_digit_by_digit() {
    let muscle = published();
    assert_eq!(muscle.pressures().len(), 20);
    let sums = |value: &dyn Fn(&AtPressure) -> f64, source: &str, unit: f64| {
        let mut sums = (0.0, 0.0);
        for (row, pressure) in muscle.pressures().iter().enumerate() {
            let value = value(&muscle.at(*pressure, source, REFUSED).unwrap()) / unit;
            sums = (sums.0 + value, sums.1 + (row + 1) as f64 * value);
        }
        sums
    };
    let inch = 0.0254;
    let stiffness = |at: &AtPressure| at.bending_stiffness;
    for (name, found, expected) in [
        ("pressure", sums(&|at| at.pressure, "euler", psi(1.0)), (1050.0, 14350.0)),
        ("length", sums(&|at| at.length, "euler", inch), (233.08, 2701.93)),
        ("inner", sums(&|at| at.inner_diameter, "euler", inch), (19.03, 197.82)),
        ("outer", sums(&|at| at.outer_diameter, "euler", inch), (20.24, 209.14)),
        ("axial", sums(&stiffness, "axial", 1.0), (0.55178, 7.23732)),
        ("euler", sums(&stiffness, "euler", 1.0), (0.22211, 2.82098)),
        ("pder_32", sums(&stiffness, "pder_32", 1.0), (0.24090, 3.05703)),
    ] {
        // Round-off of twenty terms; the last digit of the table is 1e-5.
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12 * b;
        assert!(close(found.0, expected.0) && close(found.1, expected.1), "{name}: {found:?}");
    }
}

/// Equation 8 at every row; 71 N and 650 N at the ends are what the axial column amounts to.
#[test]
fn axial_stiffness_follows_from_equation_8() {
    let muscle = published();
    for &pressure in muscle.pressures() {
        let at = muscle.at(pressure, "axial", REFUSED).unwrap();
        let squares = at.outer_diameter.powi(2) + at.inner_diameter.powi(2);
        let ei = at.axial_stiffness * squares / 16.0;
        assert!((ei / at.bending_stiffness - 1.0).abs() < 1e-14);
    }
    let newton = |pressure| muscle.at(psi(pressure), "euler", REFUSED).unwrap().axial_stiffness;
    // By hand from the rows 0.00601, 0.97, 1.07 and 0.0478, 0.93, 0.98.
    assert!((newton(5.0) - 71.459).abs() < 5e-4, "{}", newton(5.0));
    assert!((newton(100.0) - 649.451).abs() < 5e-4, "{}", newton(100.0));
}

#[test]
fn slopes_are_derivatives_of_the_values() {
    let damped = with_damping().unwrap();
    let step = 1.0; // Pa
    for pressure in [5.0, 6.2, 17.0, 44.9, 88.0, 99.8, 103.0].map(psi) {
        let at = |pressure| damped.value_and_slope(pressure, "pder_32", Extrapolation::Allowed).unwrap();
        let (low, high) = (at(pressure).0, at(pressure + step).0);
        let slope = at(pressure + step / 2.0).1;
        for (low, high, slope) in [
            (low.length, high.length, slope.length),
            (low.inner_diameter, high.inner_diameter, slope.inner_diameter),
            (low.outer_diameter, high.outer_diameter, slope.outer_diameter),
            (low.bending_stiffness, high.bending_stiffness, slope.bending_stiffness),
            (low.axial_stiffness, high.axial_stiffness, slope.axial_stiffness),
            (low.rayleigh_mass.unwrap(), high.rayleigh_mass.unwrap(), slope.rayleigh_mass.unwrap()),
            (
                low.rayleigh_stiffness.unwrap(),
                high.rayleigh_stiffness.unwrap(),
                slope.rayleigh_stiffness.unwrap(),
            ),
        ] {
            // Round-off of a difference of nearly equal values; the second-order error is smaller.
            let tolerance = 4.0 * f64::EPSILON * high.abs() / step + 1e-8 * slope.abs();
            assert!(((high - low) / step - slope).abs() < tolerance, "{pressure}: {low} {high} {slope}");
        }
    }
}

#[test]
fn the_ends_of_the_table_are_inside_however_they_are_written() {
    let muscle = published();
    for text in ["5 psi", "34.4738 kPa", "0.344738 bar", "100 psi", "689.476 kPa", "689476 Pa"] {
        let pressure = crate::quantity::Quantity::parse(text).unwrap().to("Pa").unwrap();
        let at = muscle.at(pressure, "euler", REFUSED);
        assert!(at.is_ok_and(|at| at.extrapolated.is_none()), "{text}");
    }
    assert!(muscle.at(psi(4.999), "euler", REFUSED).is_err());
    assert!(muscle.at(psi(100.01), "euler", REFUSED).is_err());
}

#[test]
fn outside_the_table_it_extrapolates_only_when_asked_and_says_so() {
    let muscle = published();
    let refused = muscle.at(psi(120.0), "euler", REFUSED).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "pressure = 120 psi (827.371 kPa): outside the table of garbulinski-2022, \
         5 to 100 psi (34.474 to 689.476 kPa); choose a pressure inside, or set extrapolation = \"allowed\""
    );
    let allowed = |pressure: f64| muscle.value_and_slope(psi(pressure), "euler", Extrapolation::Allowed);
    let (end, slope) = allowed(100.0).unwrap();
    let (beyond, slope_beyond) = allowed(120.0).unwrap();
    assert_eq!(end.extrapolated, None);
    assert_eq!(slope, slope_beyond);
    let straight = end.bending_stiffness + slope.bending_stiffness * psi(20.0);
    assert!((beyond.bending_stiffness / straight - 1.0).abs() < 1e-14);
    assert_eq!(
        beyond.extrapolated.unwrap().to_string(),
        "120 psi (827.371 kPa) lies outside the table, 5 to 100 psi (34.474 to 689.476 kPa): \
         extrapolated along straight lines"
    );
}

#[test]
fn extrapolation_stops_where_nothing_could_be() {
    let at = |pressure| published().at(pressure, "axial", Extrapolation::Allowed).unwrap_err().to_string();
    assert!(
        at(psi(-20.0))
            .starts_with("pressure = -20 psi (-137.895 kPa): extrapolation gives bending stiffness = -"),
        "{}",
        at(psi(-20.0))
    );
    assert_eq!(at(f64::NAN), "pressure = NaN Pa: must be finite");
}

#[test]
fn a_name_that_is_unknown_is_answered_with_those_that_are_not() {
    assert_eq!(
        published().at(psi(15.0), "pder32", REFUSED).unwrap_err().to_string(),
        "garbulinski-2022 has no bending stiffness \"pder32\": it has axial, euler, pder_32; did you mean \"pder_32\"?"
    );
    assert_eq!(
        Muscle::built_in("garbulinski").unwrap_err().to_string(),
        "no built-in muscle \"garbulinski\": there is garbulinski-2022, garbulinski-2022-in-motion; describe another in a file of the same form"
    );
}

fn with_damping() -> Result<Muscle, MuscleError> {
    Muscle::from_toml(
        r#"
name = "calibrated"
source = "made up"
gravity = "9.81 m/s^2"
rest = { length = "170 mm", mass_per_length = "142 g/m" }
end_fitting = { mass = "55 g", center_of_mass = "17 mm", rotary_inertia = "0.01 kg mm^2" }

[table]
columns = ["pressure", "length", "inner_diameter", "outer_diameter", "axial_stiffness", "bending_stiffness_pder_32", "rayleigh_mass", "rayleigh_stiffness"]
units = ["kPa", "mm", "mm", "mm", "N", "N mm^2", "1/s", "ms"]
rows = [
  [ 30, 170, 24, 27,  70, 9900, 0.5, 1  ],
  [200, 260, 24, 26, 200, 5600, 0.9, 2.5],
  [700, 360, 23, 25, 650, 22000, 1.1, 3 ],
]
"#,
    )
}

#[test]
fn another_muscle_may_have_damping_and_its_own_axial_stiffness() {
    let muscle = with_damping().unwrap();
    let at = muscle.at(200e3, "pder_32", REFUSED).unwrap();
    assert_eq!(at.rayleigh_mass, Some(0.9));
    assert_eq!(at.rayleigh_stiffness, Some(2.5e-3));
    assert_eq!(at.axial_stiffness, 200.0);
    assert!((at.bending_stiffness - 5.6e-3).abs() < 1e-17);
    assert_eq!(muscle.rest.braid_angle, None);
    assert!((muscle.end_fitting.rotary_inertia - 1e-8).abs() < 1e-22);
    let published = published().at(200e3, "euler", REFUSED).unwrap();
    assert_eq!((published.rayleigh_mass, published.rayleigh_stiffness), (None, None));
}

/// Both muscles have the tables of the paper; that in motion has a branch at every pressure, the other none.
#[test]
fn the_muscle_in_motion_is_that_of_the_tables_with_a_branch() {
    let (at_rest, in_motion) = (published(), Muscle::built_in(IN_MOTION).unwrap());
    for &pressure in at_rest.pressures() {
        let of = |muscle: &Muscle| muscle.at(pressure, "pder_32", REFUSED).unwrap();
        let (at_rest, in_motion) = (of(&at_rest), of(&in_motion));
        assert!(in_motion.viscoelastic.is_some_and(|[stiffness, time]| stiffness > 0.0 && time > 0.0));
        assert_eq!(AtPressure { viscoelastic: None, ..in_motion }, at_rest);
    }
    let text = BUILT_IN[1].1.replace("\"viscoelastic_branch_stiffness\"", "\"rayleigh_stiffness\"");
    let alone = Muscle::from_toml(&text.replace("\"\", \"s\"]", "\"s\", \"s\"]")).unwrap_err().to_string();
    assert!(
        alone.starts_with(
            "table.columns: \"viscoelastic_branch_stiffness\" is missing; a viscoelastic branch"
        ),
        "{alone}"
    );
}

#[test]
fn a_wrong_file_is_refused_where_it_is_wrong() {
    assert_eq!(
        error("length = \"6.69 in\"", "length = 6.69"),
        "rest.length: 6.69: needs a unit of length, such as \"6.69 mm\" or \"6.69 in\""
    );
    assert_eq!(error("\"54.92 g\"", "\"-54.92 g\""), "end_fitting.mass = -54.92 g: must not be negative");
    assert!(error("gravity =", "gravitas =").contains("unknown field `gravitas`"));
    assert_eq!(
        error("units = [\"psi\"", "units = [\"kg\""),
        "table.units, pressure: \"1 kg\" is a mass, but a pressure is due, such as \"1 psi\" or \"1 kPa\""
    );
    assert_eq!(
        error("units = [\"psi\", ", "units = ["),
        "table.units: 6 units for 7 columns; give one for each"
    );
    assert!(error("\"outer_diameter\"", "\"outer_diametre\"").starts_with(
        "table.columns: unknown column \"outer_diametre\"; did you mean \"outer_diameter\"?; known are pressure, length,"
    ));
    assert_eq!(
        error("\"bending_stiffness_euler\"", "\"bending_stiffness_axial\""),
        "table.columns: \"bending_stiffness_axial\" stands twice; give each column once"
    );
    assert_eq!(
        error("\"bending_stiffness_axial\"", "\"bending_stiffness_other\""),
        "table.columns: \"bending_stiffness_axial\" is missing; the axial stiffness follows from it; or give axial_stiffness itself"
    );
    assert_eq!(error("[ 15,  7.99, ", "[ 15, "), "table.rows: row 3 has 6 values for 7 columns");
    assert_eq!(
        error("[ 15,  7.99, ", "[ 15, -7.99, "),
        "table.rows: row 3, length = -7.99 in: must be positive"
    );
    assert_eq!(
        error("[ 15,  7.99, ", "[ 15,  nan, "),
        "table.rows: row 3, length = NaN in: must be positive"
    );
    assert_eq!(
        error("[ 15,", "[ 10,"),
        "table.rows: row 3, pressure = 10 psi: must be larger than in the row before"
    );
    assert_eq!(
        error("7.99, 0.98, 1.06", "7.99, 1.06, 0.98"),
        "table.rows: row 3, inner_diameter = 1.06 in: must be smaller than outer_diameter"
    );
}

/// A muscle whose numbers are all different, with or without columns of its own for what follows from others.
fn with_all_keys(constants: &[&str; 9], rows: &[Vec<f64>; 3], has_own: bool) -> String {
    let [gravity, length, mass, inner, outer, angle, tip, center, inertia] = constants;
    let mut columns =
        vec!["pressure", "length", "bending_stiffness_axial", "bending_stiffness_own", "rayleigh_mass"];
    let mut units = vec!["kPa", "mm", "N mm^2", "N mm^2", "1/s", "ms", "", "s"];
    columns.extend(["rayleigh_stiffness", "viscoelastic_branch_stiffness", "viscoelastic_relaxation_time"]);
    if has_own {
        columns.extend(["inner_diameter", "outer_diameter", "axial_stiffness"]);
        units.extend(["mm", "mm", "N"]);
    }
    let rows: Vec<&[f64]> = rows.iter().map(|row| &row[..columns.len()]).collect();
    format!(
        "name = \"all\"\nsource = \"made up\"\ngravity = \"{gravity} m/s^2\"\n[rest]\nlength = \"{length} mm\"\n\
         mass_per_length = \"{mass} g/m\"\ninner_diameter = \"{inner} mm\"\nouter_diameter = \"{outer} mm\"\n\
         braid_angle = \"{angle} deg\"\n[end_fitting]\nmass = \"{tip} g\"\ncenter_of_mass = \"{center} mm\"\n\
         rotary_inertia = \"{inertia} kg mm^2\"\n[table]\ncolumns = {columns:?}\nunits = {units:?}\nrows = {rows:?}\n"
    )
}

/// A key that is read and never used would leave everything as it is. What has a column of its own needs no resting value,
/// and the axial test's EI is then one estimate among others.
#[test]
fn every_number_of_a_muscle_changes_something() {
    let constants = ["9.81", "170", "142", "24", "27", "13", "55", "17", "0.01"];
    let rows = [
        vec![30.0, 171.0, 6000.0, 9900.0, 0.5, 1.0, 0.1, 0.2, 24.0, 27.0, 70.0],
        vec![200.0, 260.0, 13000.0, 5600.0, 0.9, 2.5, 0.3, 0.3, 23.9, 26.0, 200.0],
        vec![700.0, 360.0, 48000.0, 22000.0, 1.1, 3.0, 0.4, 0.5, 23.0, 25.0, 650.0],
    ];
    let facts = |constants: &[&str; 9], rows: &[Vec<f64>; 3], has_own: bool| {
        let muscle = Muscle::from_toml(&with_all_keys(constants, rows, has_own)).unwrap();
        let of = |source: &str| {
            let at = muscle.at(199e3, source, REFUSED).unwrap();
            format!("{at:?} {:?} {:?}", muscle.rod(&at), muscle.spec(&at).effects)
        };
        of("own") + &of("axial") + &muscle.described()
    };
    for has_own in [false, true] {
        let before = facts(&constants, &rows, has_own);
        for k in 0..constants.len() {
            let mut changed = constants;
            let other = format!("{}1", changed[k]);
            changed[k] = if changed[k].contains('.') {
                &other
            } else {
                ["171", "143", "23", "28", "14", "56", "18"][k - 1]
            };
            let is_used = !has_own || ![3, 4].contains(&k);
            assert_eq!(facts(&changed, &rows, has_own) != before, is_used, "{has_own}: constant {k}");
        }
        for column in 0..if has_own { 11 } else { 8 } {
            let mut changed = rows.clone();
            changed.iter_mut().for_each(|row| row[column] *= 1.001);
            assert_ne!(facts(&constants, &changed, has_own), before, "{has_own}: column {column}");
        }
    }
}
