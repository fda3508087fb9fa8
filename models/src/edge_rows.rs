//! Derivatives of the forces in the edges, row by row, from those of moments and axial forces by turns and lengths.

use crate::by_turns::{Block, EdgeRow, EdgeRows, HALF_REACH};
use crate::number::Plain;
use crate::plane::left;
use crate::tangent::Tangent;

/// Derivatives of the forces in the edges by the edge vectors.
pub(crate) struct Stiffness<'a, T>(pub &'a Tangent<T>);

impl<T: Plain> EdgeRows<T> for Stiffness<'_, T> {
    #[inline(always)]
    fn write(&self, j: usize, row: &mut EdgeRow<T>) {
        let Tangent { by_turns: turns, by_turn_rates: rates, angle_by_edge, rate_by_edge, .. } = self.0;
        let n = self.0.tangent.len();
        let (by_turns, by_turn_rates) = (turns.turn_by_turns(j), rates.turn_by_turns(j));
        let (by_lengths, by_length_rates) = (turns.turn_by_lengths(j), rates.turn_by_lengths(j));
        let (pull_by_turns, pull_by_turn_rates) = (turns.length_by_turns(j), rates.length_by_turns(j));
        let (along, across) = (self.0.tangent[j], angle_by_edge[j]);
        for (k, block) in row.iter_mut().enumerate() {
            *block = Block::default();
            let Some(other) = (j + k).checked_sub(HALF_REACH).filter(|other| *other < n) else { continue };
            let (g, h) = (angle_by_edge[other], rate_by_edge[other]);
            let mut turned = [T::default(); 2];
            for m in 0..2 {
                turned[m] = by_turns[k] * g[m] + by_turn_rates[k] * h[m];
            }
            // The arcs of edges join neighbours alone.
            if let Some(near) = (k + 1).checked_sub(HALF_REACH).filter(|near| *near < 3) {
                let (t, s) = (self.0.tangent[other], self.0.length_rate_by_edge[other]);
                let mut pulled = [T::default(); 2];
                for m in 0..2 {
                    pulled[m] = pull_by_turns[near] * g[m] + pull_by_turn_rates[near] * h[m];
                    turned[m] += by_lengths[near] * t[m] + by_length_rates[near] * s[m];
                    if near == 1 {
                        pulled[m] += turns.lengths[j] * t[m] + rates.lengths[j] * s[m];
                    }
                }
                block.add(Block::outer(along, pulled));
            }
            block.add(Block::outer(across, turned));
        }
        let (normal, per_length) = (left(along), self.0.per_length[j]);
        let mut crossed = Block::outer(along, normal);
        crossed.add(crossed.transpose());
        let mut added = Block::outer(normal, normal).times(self.0.pull[j] * per_length);
        added.subtract(crossed.times(self.0.torque[j] * per_length * per_length));
        row[HALF_REACH].add(added);
    }
}

/// Derivatives of the forces in the edges by the rates of the edge vectors.
pub(crate) struct Damping<'a, T>(pub &'a Tangent<T>);

impl<T: Plain> EdgeRows<T> for Damping<'_, T> {
    #[inline(always)]
    fn write(&self, j: usize, row: &mut EdgeRow<T>) {
        let Tangent { by_turn_rates: rates, angle_by_edge, .. } = self.0;
        let n = self.0.tangent.len();
        let (by_turns, by_lengths) = (rates.turn_by_turns(j), rates.turn_by_lengths(j));
        let pull_by_turns = rates.length_by_turns(j);
        let (along, across) = (self.0.tangent[j], angle_by_edge[j]);
        for (k, block) in row.iter_mut().enumerate() {
            *block = Block::default();
            let Some(other) = (j + k).checked_sub(HALF_REACH).filter(|other| *other < n) else { continue };
            let g = angle_by_edge[other];
            let mut turned = [by_turns[k] * g[0], by_turns[k] * g[1]];
            if let Some(near) = (k + 1).checked_sub(HALF_REACH).filter(|near| *near < 3) {
                let t = self.0.tangent[other];
                let mut pulled = [pull_by_turns[near] * g[0], pull_by_turns[near] * g[1]];
                for m in 0..2 {
                    turned[m] += by_lengths[near] * t[m];
                    if near == 1 {
                        pulled[m] += rates.lengths[j] * t[m];
                    }
                }
                block.add(Block::outer(along, pulled));
            }
            block.add(Block::outer(across, turned));
        }
    }
}
