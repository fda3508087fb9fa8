//! Cases of a page that differ in some quantities: a slider for each quantity, by which a reader chooses among them.

use models::digits::significant;
use serde_json::{Value, json};

use crate::picture::chart::column_in;

/// Cases up to which a page has sliders: a slider of more steps than pixels leaves cases out.
const MOST_CASES: usize = 1000;

/// What varies among the cases of a page, which are numbered from zero.
#[derive(Clone, Debug, Default)]
pub struct Family {
    axes: Vec<Axis>,
}

/// One quantity.
#[derive(Clone, Debug)]
struct Axis {
    name: String,
    /// Its values with their unit, in the order of the slider.
    values: Vec<String>,
    /// Which of them each case has.
    places: Vec<usize>,
}

impl Family {
    /// With one more quantity and its value in each case; nothing of one that does not vary.
    pub fn by(self, name: &str, unit: &str, of_cases: &[f64]) -> Self {
        let mut distinct = of_cases.to_vec();
        distinct.sort_by(f64::total_cmp);
        distinct.dedup();
        let place = |value: &f64| distinct.partition_point(|own| own.total_cmp(value).is_lt());
        let word = |value: &f64| format!("{} {unit}", told(*value)).trim_end().to_owned();
        self.with(name, distinct.iter().map(word).collect(), of_cases.iter().map(place).collect())
    }

    /// The same of a quantity that is a word, in the order in which the words come.
    pub fn by_words(self, name: &str, of_cases: &[String]) -> Self {
        let mut distinct: Vec<String> = Vec::new();
        for word in of_cases {
            if !distinct.contains(word) {
                distinct.push(word.clone());
            }
        }
        let place = |word: &String| distinct.iter().position(|own| own == word).unwrap_or(0);
        let places = of_cases.iter().map(place).collect();
        self.with(name, distinct, places)
    }

    fn with(mut self, name: &str, values: Vec<String>, places: Vec<usize>) -> Self {
        if values.len() > 1 && places.len() <= MOST_CASES {
            self.axes.push(Axis { name: name.to_owned(), values, places });
        }
        self
    }

    /// Whether nothing can be chosen.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// As the script reads it.
    pub fn json(&self) -> Value {
        let axis = |own: &Axis| {
            let places: Vec<f64> = own.places.iter().map(|place| *place as f64).collect();
            json!({ "name": own.name, "values": own.values, "places": column_in(&places, 1.0) })
        };
        json!({ "axes": self.axes.iter().map(axis).collect::<Vec<_>>() })
    }
}

/// Four digits that count, without zeros at the end, and with a true minus.
fn told(value: f64) -> String {
    let text = significant(value, 4);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "\u{2212}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slider goes through the values from the least to the greatest, whatever the order of the cases.
    #[test]
    fn each_case_has_its_place_on_each_slider() {
        let words = ["consistent", "paper", "consistent"].map(str::to_owned);
        let family = Family::default()
            .by("pressure", "kPa", &[276.0, 103.4, -1.0])
            .by("payload", "g", &[50.0; 3])
            .by_words("rod.scheme", &words);
        let axes = family.json()["axes"].clone();
        assert_eq!(axes.as_array().map(Vec::len), Some(2), "what does not vary has no slider: {axes}");
        assert_eq!(axes[0]["values"], json!(["\u{2212}1 kPa", "103.4 kPa", "276 kPa"]));
        assert_eq!(axes[0]["places"], json!({ "unit": 1.0, "from": 2, "step": -1, "count": 3 }));
        assert_eq!(axes[1]["values"], json!(["consistent", "paper"]));
        assert_eq!(axes[1]["places"]["steps"], json!([0, 1, -1]));
        assert!(Family::default().by("x", "", &[1.0; 5]).is_empty());
    }
}
