//! Whether chains of a sampler agree, and how many independent draws they are worth.
//!
//! Sources: Vehtari et al. (2021), Bayesian Analysis 16, 667-718; Geyer (1992), Statistical Science 7, 473-483.

/// R-hat and effective sample size of draws of shape `[chains][draws]`, both by ranks and halves of the chains; none for
/// fewer than four draws a chain, or where nothing varies.
pub fn convergence(chains: &[Vec<f64>]) -> Option<[f64; 2]> {
    let [r_hat, size] = of_halves(&normal_scores(chains))?;
    // Chains may agree in their place and not in their spread.
    let mut all: Vec<f64> = chains.iter().flatten().copied().collect();
    all.sort_by(f64::total_cmp);
    let median = 0.5 * (all[(all.len() - 1) / 2] + all[all.len() / 2]);
    let folded: Vec<Vec<f64>> =
        chains.iter().map(|chain| chain.iter().map(|value| (value - median).abs()).collect()).collect();
    let [of_spread, _] = of_halves(&normal_scores(&folded))?;
    Some([r_hat.max(of_spread), size])
}

fn of_halves(ranked: &[Vec<f64>]) -> Option<[f64; 2]> {
    let halves: Vec<&[f64]> = ranked
        .iter()
        .flat_map(|chain| {
            let half = chain.len() / 2;
            [&chain[..half], &chain[chain.len() - half..]]
        })
        .collect();
    let n = halves.first()?.len();
    if n < 2 {
        return None;
    }
    let (count, size) = (halves.len() as f64, n as f64);
    let means: Vec<f64> = halves.iter().map(|half| half.iter().sum::<f64>() / size).collect();
    let whole = means.iter().sum::<f64>() / count;
    let between = size / (count - 1.0) * means.iter().map(|mean| (mean - whole).powi(2)).sum::<f64>();
    let covariances: Vec<Vec<f64>> =
        halves.iter().zip(&means).map(|(half, mean)| autocovariance(half, *mean)).collect();
    let within = covariances.iter().map(|own| own[0]).sum::<f64>() / count * size / (size - 1.0);
    let variance = within * (size - 1.0) / size + between / size;
    if within.is_nan() || within <= 0.0 {
        return None;
    }
    let correlation = |lag: usize| {
        let mean = covariances.iter().map(|own| own[lag]).sum::<f64>() / count;
        1.0 - (within - mean) / variance
    };
    // Geyer's initial monotone sequence of sums of pairs; of the last pair the even lag counts, once.
    let (mut sum, mut least) = (0.0, f64::INFINITY);
    let (mut even, mut own, mut lag) = (1.0, 1.0 + correlation(1), 2);
    while lag + 2 < n && own > 0.0 {
        least = own.min(least);
        sum += least;
        (even, own) = (correlation(lag), correlation(lag) + correlation(lag + 1));
        lag += 2;
    }
    let draws = count * size;
    // Chains that swing about the mean are worth more than independent draws; by this much at most, as ArviZ has it.
    let time = (2.0 * sum - 1.0 + f64::max(even, 0.0)).max(1.0 / draws.log10());
    Some([(variance / within).sqrt(), draws / time])
}

/// Normal scores of the ranks of all draws, by which heavy tails do no harm.
fn normal_scores(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut all: Vec<(f64, usize, usize)> = (chains.iter().enumerate())
        .flat_map(|(c, chain)| chain.iter().enumerate().map(move |(k, value)| (*value, c, k)))
        .collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut scores: Vec<Vec<f64>> = chains.iter().map(|chain| vec![0.0; chain.len()]).collect();
    let count = all.len() as f64;
    let mut first = 0;
    while first < all.len() {
        let equal = all[first..].iter().take_while(|own| own.0 == all[first].0).count();
        let rank = first as f64 + 0.5 * (equal as f64 + 1.0);
        let score = normal_quantile((rank - 0.375) / (count + 0.25));
        all[first..first + equal].iter().for_each(|(_, c, k)| scores[*c][*k] = score);
        first += equal;
    }
    scores
}

/// Of each lag, over the number of all draws.
fn autocovariance(draws: &[f64], mean: f64) -> Vec<f64> {
    let n = draws.len();
    let of = |lag: usize| {
        let products = draws.iter().zip(&draws[lag..]).map(|(a, b)| (a - mean) * (b - mean));
        products.sum::<f64>() / n as f64
    };
    (0..n).map(of).collect()
}

/// Inverse of the normal distribution function, to 4.5e-4. Source: Abramowitz and Stegun (1964), 26.2.23.
fn normal_quantile(share: f64) -> f64 {
    let tail = share.min(1.0 - share);
    let t = (-2.0 * tail.ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    let far = t - above / below;
    if share < 0.5 { -far } else { far }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal::normal;
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;

    /// Draws of an autoregression are worth `(1 − ρ) / (1 + ρ)` of as many independent ones, whatever the tails; chains that are
    /// apart, or of another spread, do not agree.
    #[test]
    fn draws_that_follow_one_another_count_for_less() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut chains = |correlation: f64, of: &dyn Fn(usize, f64) -> f64| -> Vec<Vec<f64>> {
            let mut one = |c: usize| {
                let mut x = normal(&mut random);
                let mut next = |_| {
                    x = correlation * x + (1.0 - correlation * correlation).sqrt() * normal(&mut random);
                    of(c, x)
                };
                (0..2000).map(&mut next).collect()
            };
            (0..4).map(&mut one).collect()
        };
        for correlation in [0.0, 0.6, -0.3] {
            for of in [|_, x| x, |_, x: f64| x.sinh().powi(3)] as [fn(usize, f64) -> f64; 2] {
                let [r_hat, size] = convergence(&chains(correlation, &of)).unwrap();
                let due = 8000.0 * (1.0 - correlation) / (1.0 + correlation);
                // Geyer's sum of 8000 draws has an error near a tenth.
                assert!((size / due - 1.0).abs() < 0.3, "{correlation}: {size}, due {due}");
                assert!(r_hat < 1.01, "{r_hat}");
            }
        }
        let apart = convergence(&chains(0.0, &|c, x| x + 0.5 * c as f64)).unwrap();
        let spread = convergence(&chains(0.0, &|c, x| if c == 0 { 3.0 * x } else { x })).unwrap();
        assert!(apart[0] > 1.1 && apart[1] < 100.0 && spread[0] > 1.05, "{apart:?}, {spread:?}");
        assert_eq!(convergence(&[vec![1.0; 100], vec![1.0; 100]]), None);
    }
}
