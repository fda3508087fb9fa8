//! A chart as the JSON that a page's script reads. Numbers are kept to some 1e-5 of their range, as whole multiples of
//! a unit and as differences from the one before, which keeps pages small.

use plotters::prelude::RGBColor;
use serde_json::{Map, Value, json};

use crate::picture::chart::{Cases, Chart, Key, Mark, Point, Scale, Shape, Stroke};

/// Least number of units in the range of a column.
const FINE: f64 = 1e4;

/// All of a chart.
pub fn json(of: &Chart) -> Value {
    if let Some(why) = &of.why {
        return json!({ "title": of.title, "why": why });
    }
    let mut last: Option<Vec<f64>> = None;
    let of_cases = |k: usize, mut mark: Value| {
        match of.cases.get(&k) {
            None => {}
            Some(Cases::One(case)) => mark["case"] = json!(case),
            Some(Cases::Chosen(case)) => (mark["case"], mark["chosen"]) = (json!(case), json!(true)),
            Some(Cases::Each(all)) => {
                let all: Vec<f64> = all.iter().map(|case| *case as f64).collect();
                mark["cases"] = column_in(&all, 1.0);
            }
        }
        mark
    };
    let marks: Vec<Value> =
        of.marks.iter().enumerate().map(|(k, own)| of_cases(k, mark(of, own, &mut last))).collect();
    let keys: Vec<Value> = of
        .keys
        .iter()
        .map(|key| json!({ "name": key.text, "shape": shape(key), "look": look(&key.stroke) }))
        .collect();
    json!({
        "title": of.title,
        "x": scale(&of.x),
        "y": scale(&of.y),
        "equal": of.is_equal,
        "aspect": (1e3 * of.aspect).round() / 1e3,
        "keys": keys,
        "marks": marks,
    })
}

/// Numbers of one kind, not all of which need be evenly spaced.
pub fn column(values: &[f64]) -> Value {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(*value), high.max(*value)));
    let spread = (high - low).max(1e-6 * high.abs().max(low.abs())).max(1e-12);
    let unit = if values.is_empty() { 1.0 } else { 10f64.powf((spread / FINE).log10().floor()) };
    column_in(values, unit)
}

/// Numbers as whole multiples of a unit, each less the one before.
pub fn column_in(values: &[f64], unit: f64) -> Value {
    let whole: Vec<i64> = values.iter().map(|value| (value / unit).round() as i64).collect();
    let before = [0].into_iter().chain(whole.iter().copied());
    let steps: Vec<i64> = whole.iter().zip(before).map(|(own, before)| own - before).collect();
    match steps[..] {
        [from, step, .., last] if step == last && steps[1..].iter().all(|own| *own == step) => {
            json!({ "unit": unit, "from": from, "step": step, "count": whole.len() })
        }
        _ => json!({ "unit": unit, "steps": steps }),
    }
}

fn scale(of: &Scale) -> Value {
    json!({ "label": of.label, "range": [of.range.start, of.range.end] })
}

fn shape(of: &Key) -> &'static str {
    match of.shape {
        Shape::Line => "line",
        Shape::Dot => "dot",
        Shape::Ring => "ring",
        Shape::Band => "band",
    }
}

fn color(RGBColor(red, green, blue): RGBColor) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// How something looks.
pub fn look(of: &Stroke) -> Value {
    let mut look = Map::new();
    look.insert("color".to_owned(), json!(color(of.color)));
    look.insert("width".to_owned(), json!(of.width));
    if let Some((dash, gap)) = of.dash {
        look.insert("dash".to_owned(), json!([dash, gap]));
    }
    if of.alpha < 1.0 {
        look.insert("alpha".to_owned(), json!((1e3 * of.alpha).round() / 1e3));
    }
    Value::Object(look)
}

/// The key that a mark belongs to, by which it is hidden and named: one of its shape and look, or else of its look.
fn key(of: &Chart, shape: Shape, stroke: &Stroke) -> Option<usize> {
    let same = |key: &Key, with_dash: bool| {
        let is_dash = key.stroke.dash == stroke.dash && (key.stroke.width - stroke.width).abs() < 1e-9;
        key.stroke.color == stroke.color && (!with_dash || is_dash)
    };
    let of_shape = |key: &Key| key.shape == shape;
    let find = |test: &dyn Fn(&Key) -> bool| of.keys.iter().position(test);
    find(&|key| of_shape(key) && same(key, true))
        .or_else(|| find(&|key| shape != Shape::Line && of_shape(key) && same(key, false)))
        .or_else(|| find(&|key| same(key, true)))
        .or_else(|| find(&|key| shape != Shape::Line && key.shape == Shape::Line && same(key, false)))
}

fn mark(of: &Chart, mark: &Mark, last: &mut Option<Vec<f64>>) -> Value {
    let points =
        |kind: &str, shape: Shape, points: &[Point], stroke: &Stroke, last: &mut Option<Vec<f64>>| {
            let finite = points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
            let (x, y): (Vec<f64>, Vec<f64>) = finite.copied().unzip();
            // Lines over the same times share them.
            let shared = last.as_ref() == Some(&x);
            let over = if shared { json!("same") } else { column(&x) };
            *last = Some(x);
            let mut own = json!({ "kind": kind, "look": look(stroke), "x": over, "y": column(&y) });
            if let Some(key) = key(of, shape, stroke) {
                own["key"] = json!(key);
            }
            own
        };
    match mark {
        Mark::Line { points: own, stroke, times } => {
            let mut value = points("line", Shape::Line, own, stroke, last);
            if let Some(times) = times {
                value["times"] = column(times);
            }
            value
        }
        Mark::Dots { points: own, stroke, radius } => {
            let mut value = points("dots", Shape::Dot, own, stroke, last);
            value["radius"] = json!(radius);
            value
        }
        Mark::Rings { points: own, stroke, radius } => {
            let mut value = points("rings", Shape::Ring, own, stroke, last);
            value["radius"] = json!(radius);
            value
        }
        Mark::Band { points: own, stroke } => {
            let lower: Vec<Point> = own.iter().map(|(x, ends)| (*x, ends[0])).collect();
            let upper: Vec<f64> = own.iter().map(|(_, ends)| ends[1]).collect();
            let mut value = points("band", Shape::Band, &lower, stroke, last);
            value["upper"] = column(&upper);
            value
        }
        Mark::Strip { x, y } => {
            json!({ "kind": "strip", "x": [x.start, x.end], "y": [y.start, y.end] })
        }
        Mark::Cell { x, y, color: own, value } => json!({
            "kind": "cell", "x": [x.start, x.end], "y": [y.start, y.end], "color": color(*own), "value": value
        }),
        Mark::Number { at, text, color: own } => {
            json!({ "kind": "number", "at": [at.0, at.1], "text": text, "color": color(*own) })
        }
        Mark::Text { at, text } => json!({ "kind": "text", "at": [at.0, at.1], "text": text }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::drawn;
    use crate::picture::panel::{Axis, Panel};
    use crate::picture::tests::chart;

    /// Numbers as the script reads them.
    fn numbers(of: &Value) -> Vec<f64> {
        let unit = of["unit"].as_f64().expect("a unit");
        if let Some(count) = of["count"].as_u64() {
            let [from, step] = ["from", "step"].map(|name| of[name].as_i64().expect("a number"));
            return (0..count as i64).map(|k| unit * (from + k * step) as f64).collect();
        }
        let steps = of["steps"].as_array().expect("steps").iter().filter_map(Value::as_i64);
        let sum = |sum: &mut i64, step: i64| {
            *sum += step;
            Some(unit * *sum as f64)
        };
        steps.scan(0, sum).collect()
    }

    #[test]
    fn a_column_reads_back_to_a_ten_thousandth_of_its_range() {
        let curve: Vec<f64> = (0..400).map(|k| 1e-3 * (0.05 * f64::from(k)).sin() - 7.0).collect();
        let even: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
        for values in [curve, even, vec![3.0], vec![2.0, 2.0], Vec::new()] {
            let read = numbers(&column(&values));
            assert_eq!(read.len(), values.len());
            let range = values.iter().fold(0.0, |most: f64, own| most.max((own - values[0]).abs()));
            let off = read.iter().zip(&values).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off <= 0.5e-4 * range.max(3e-2), "{off} of {range}");
        }
        assert_eq!(column(&[0.0, 0.01, 0.02, 0.03])["count"], 4);
    }

    /// A mark gives its case, or that of each of its points; a picture leaves out what is there only while chosen.
    #[test]
    fn marks_tell_their_cases() {
        let line = Stroke::new(RGBColor(0, 114, 178), 1.0);
        let drawing = drawn((400, 300), |page| {
            let mut panel = Panel::new(page, "", &Axis(0.0..2.0, "x"), &Axis(0.0..2.0, "y"), &[])?;
            let points = || [(0.0, 0.5), (2.0, 1.0)].into_iter();
            panel.of_cases(Some(Cases::One(3))).line(points(), &line)?;
            let wine = Stroke::new(RGBColor(136, 34, 85), 1.0);
            panel.of_cases(Some(Cases::Chosen(4))).line(points(), &wine)?;
            panel.of_cases(Some(Cases::Each(vec![7, 5]))).dots(points(), &line, 2.0)?;
            panel.of_cases(None).line(points(), &line)
        });
        let value = json(&drawing.charts[0]);
        let of = |name: &str| -> Vec<Value> { (0..4).map(|k| value["marks"][k][name].clone()).collect() };
        assert_eq!(of("case"), [json!(3), json!(4), Value::Null, Value::Null]);
        assert_eq!(of("chosen"), [Value::Null, json!(true), Value::Null, Value::Null]);
        assert_eq!(numbers(&value["marks"][2]["cases"]), [7.0, 5.0]);
        assert!(drawing.svg.contains("#0072B2") && !drawing.svg.contains("#882255"));
    }

    /// What is drawn is what the JSON says: each mark, in its order, with its points, its look and its key.
    #[test]
    fn the_json_of_a_chart_has_all_that_is_drawn() {
        let drawing = chart("abc");
        let value = json(&drawing.charts[0]);
        let marks = value["marks"].as_array().expect("marks");
        let kinds: Vec<_> = marks.iter().map(|mark| mark["kind"].as_str().expect("a kind")).collect();
        assert_eq!(kinds, ["line", "dots", "text"]);
        let near = |of: &Value, expected: &[f64]| {
            let read = numbers(of);
            assert!(read.len() == expected.len(), "{of}");
            assert!(read.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{read:?} {expected:?}");
        };
        near(&marks[0]["x"], &[0.0, 0.7, 2.0]);
        near(&marks[0]["y"], &[-0.5, 0.25, 1.0]);
        near(&marks[1]["y"], &[0.9]);
        assert_eq!((&marks[0]["key"], &marks[1]["key"]), (&json!(0), &json!(1)));
        assert_eq!(marks[0]["look"], json!({ "color": "#0072b2", "width": 1.0, "dash": [3.0, 2.0] }));
        assert_eq!(value["y"], json!({ "label": "abc", "range": [-1.0, 1.0] }));
        assert!(drawing.svg.contains("#0072B2") && drawing.svg.matches("<circle").count() >= 2);
    }
}
