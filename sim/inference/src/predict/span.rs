//! One value, several, or a range of them, as a command line says it: `80g`, `0g,50g,100g`, `0g..200g`, `0g..200g:5`.

use models::quantity::Quantity;

/// Values of a range that says no number.
const COUNT: usize = 11;
/// Values admitted.
const MOST: usize = 1000;

/// The values that a text means, in a unit, ascending.
/// # Errors
/// What is wrong with it, and what would do.
pub fn values(text: &str, unit: &str) -> Result<Vec<f64>, String> {
    let one = |text: &str| -> Result<f64, String> {
        let quantity = Quantity::parse(text.trim()).and_then(|quantity| quantity.to(unit));
        quantity.map_err(|error| error.to_string())
    };
    let Some((low, rest)) = text.split_once("..") else {
        let mut all = text.split(',').map(one).collect::<Result<Vec<f64>, _>>()?;
        all.sort_by(f64::total_cmp);
        all.dedup();
        return Ok(all);
    };
    let (high, count) = match rest.rsplit_once(':') {
        None => (rest, COUNT),
        Some((high, count)) => {
            let number = count.trim().parse().ok().filter(|count| (2..=MOST).contains(count));
            (
                high,
                number.ok_or_else(|| {
                    format!("after the colon comes how many values, 2 to {MOST}, not {count:?}")
                })?,
            )
        }
    };
    let (low, high) = (one(low)?, one(high)?);
    if low >= high {
        return Err("a range goes from the smaller to the larger value, such as 0g..200g".to_owned());
    }
    let step = (high - low) / (count - 1) as f64;
    Ok((0..count).map(|k| if k + 1 == count { high } else { low + step * k as f64 }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_several_and_ranges_are_understood() {
        assert_eq!(values("80g", "kg").unwrap(), [0.08]);
        assert_eq!(values("100 g, 0g, 50g,50 g", "kg").unwrap(), [0.0, 0.05, 0.1]);
        assert_eq!(values("0g..200g", "kg").unwrap().len(), COUNT);
        let five = values("0 g .. 0.2 kg:5", "kg").unwrap();
        assert!(five.iter().zip([0.0, 0.05, 0.1, 0.15, 0.2]).all(|(a, b)| (a - b).abs() < 1e-15), "{five:?}");
        assert_eq!(five[4], 0.2);
    }

    #[test]
    fn what_makes_no_sense_is_refused_with_what_would_do() {
        let says = |text: &str, expected: &str| {
            let words = values(text, "kg").unwrap_err();
            assert!(words.contains(expected), "{text}: {words}");
        };
        says("200g..0g", "from the smaller to the larger");
        says("0g..200g:1", "how many values, 2 to 1000");
        says("0g..200g:many", "how many values");
        says("0g..", "");
        says("5 m", "length");
        says("", "");
    }
}
