//! The reduced model as a header for C: matrices, and one step.

use std::fmt::Write;

use crate::linear::{LinearAnswer, SignalAnswer};

/// The text; none without a reduced model and samples.
pub(super) fn of(answer: &LinearAnswer) -> Option<String> {
    let reduced = answer.reduced.as_ref()?;
    let (matrices, sample) = (reduced.discrete.as_ref()?, answer.sample_s?);
    let signals = |kind: &str, all: &[SignalAnswer]| -> String {
        let line = |(k, own): (usize, &SignalAnswer)| {
            format!(" * {kind}[{k}]: {} in {}, counted from {:?}\n", own.name, plain(&own.unit), own.at_rest)
        };
        all.iter().enumerate().map(line).collect()
    };
    let mut text = format!(
        "/* Small motions about a rest, by efam: x becomes A x + B u every {sample:?} s, y = C x + D u.\n{}{} */\n\
         #ifndef EFAM_LINEAR_H\n#define EFAM_LINEAR_H\n\n#define EFAM_STATES {}\n#define EFAM_INPUTS {}\n\
         #define EFAM_OUTPUTS {}\n#define EFAM_SAMPLE {sample:?}\n\n",
        signals("u", &answer.inputs),
        signals("y", &answer.outputs),
        reduced.states,
        answer.inputs.len(),
        answer.outputs.len(),
    );
    for (name, shape, rows) in [
        ("a", "[EFAM_STATES][EFAM_STATES]", &matrices.a),
        ("b", "[EFAM_STATES][EFAM_INPUTS]", &matrices.b),
        ("c", "[EFAM_OUTPUTS][EFAM_STATES]", &matrices.c),
        ("d", "[EFAM_OUTPUTS][EFAM_INPUTS]", &matrices.d),
    ] {
        let row = |row: &Vec<f64>| {
            let numbers: Vec<String> = row.iter().map(|number| format!("{number:?}")).collect();
            format!("    {{{}}}", numbers.join(", "))
        };
        let rows: Vec<String> = rows.iter().map(row).collect();
        let _ = writeln!(text, "static const double efam_{name}{shape} = {{\n{}\n}};\n", rows.join(",\n"));
    }
    text += STEP;
    Some(text)
}

/// No name of a unit ends the comment.
fn plain(unit: &str) -> String {
    if unit.is_empty() { "1".to_owned() } else { unit.replace("*/", "* /") }
}

const STEP: &str = "/* Outputs of this sample, then the state of the next. */
static inline void efam_step(double x[EFAM_STATES], const double u[EFAM_INPUTS], double y[EFAM_OUTPUTS])
{
    double next[EFAM_STATES];
    int i, j;
    for (i = 0; i < EFAM_OUTPUTS; i++) {
        y[i] = 0.0;
        for (j = 0; j < EFAM_STATES; j++) y[i] += efam_c[i][j] * x[j];
        for (j = 0; j < EFAM_INPUTS; j++) y[i] += efam_d[i][j] * u[j];
    }
    for (i = 0; i < EFAM_STATES; i++) {
        next[i] = 0.0;
        for (j = 0; j < EFAM_STATES; j++) next[i] += efam_a[i][j] * x[j];
        for (j = 0; j < EFAM_INPUTS; j++) next[i] += efam_b[i][j] * u[j];
    }
    for (i = 0; i < EFAM_STATES; i++) x[i] = next[i];
}

#endif
";
