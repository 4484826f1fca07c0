//! One output's model as parameters of a design's columns, whatever its structure, and what a model
//! file says of it.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::design::{RegressionDesign, Role};
use super::drift::ChosenDrift;
use super::normal_equations::{ModelTerm, in_columns};
use super::residuals::Residuals;
use crate::model::{Class, Followed, ModelOutput};

/// Parameters with their covariance.
pub struct FittedOutput<'a> {
    pub design: &'a RegressionDesign,
    pub terms: &'a [ModelTerm],
    pub theta: &'a DVector<f64>,
    pub covariance: &'a DMatrix<f64>,
    /// Subtracted from the output before it entered the sums.
    pub shift: f64,
    /// How its offset moves.
    pub drift: Option<&'a ChosenDrift>,
    pub sample_period_s: f64,
}

impl FittedOutput<'_> {
    /// What each column of the design weighs.
    pub fn weights(&self) -> Vec<f64> {
        in_columns(self.terms, self.theta, self.design.width())
    }

    /// Rates of a bank that the model has: poles of filters are not among them.
    pub fn rates_rad_s(&self, bank: usize) -> Vec<f64> {
        let rate = |term: &ModelTerm| match term.role {
            Role::Relaxation { bank: own, rate_rad_s, .. } if own == bank => Some(rate_rad_s),
            _ => None,
        };
        self.terms.iter().filter_map(rate).collect()
    }

    /// Offset and figures of its residuals.
    pub fn output(&self, name: &str, residuals: &Residuals) -> ModelOutput {
        let offset = self.terms.iter().position(|term| term.role == Role::Offset).unwrap_or(0);
        ModelOutput {
            name: name.to_owned(),
            offset_c: self.theta[offset] + self.shift,
            se_offset_c: self.se(offset),
            residual_rms: residuals.rms(),
            fit_percent: residuals.fit_percent(),
            spread_rms: Some(residuals.spread_rms()),
            whiteness: residuals.whiteness(),
            drift: self.drift.map(|drift| drift.described(residuals.rms().powi(2), self.sample_period_s)),
            forecast_rms: None,
        }
    }

    /// Resistances of one bank with their standard errors. `log_rates` are the parameters that
    /// stand for the logarithms of its rates; none where those are given.
    pub fn class(&self, bank: usize, log_rates: Range<usize>) -> Class {
        let its = (0..self.terms.len()).filter(|&term| self.terms[term].role.bank() == Some(bank));
        let (feed, relaxations): (Vec<usize>, Vec<usize>) =
            its.partition(|&term| matches!(self.terms[term].role, Role::FeedThrough { .. }));
        let (gain, variance) = steady_gain(self.terms, self.theta, self.covariance, bank);
        // A feed-through that the model does not have is known to be none.
        let known: Vec<Option<usize>> =
            (relaxations.iter().copied().map(Some)).chain([feed.first().copied()]).chain(log_rates.map(Some)).collect();
        let triangle = (0..known.len()).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let covariance = triangle.map(|(i, j)| known[i].zip(known[j]).map_or(0.0, |at| self.covariance[at]));
        Class {
            covariance: Some(covariance.collect()),
            r_k_per_w: relaxations.iter().map(|&term| self.theta[term]).collect(),
            se_k_per_w: relaxations.iter().map(|&term| self.se(term)).collect(),
            steady_gain_k_per_w: gain,
            se_steady_gain_k_per_w: variance.sqrt(),
            interval_95: None,
            feed_through_k_per_w: feed.first().map_or(0.0, |&term| self.theta[term]),
            se_feed_through_k_per_w: feed.first().map_or(0.0, |&term| self.se(term)),
        }
    }

    /// How it follows what drives a bank in kelvins: the same sums as those of resistances.
    pub fn followed(&self, bank: usize) -> Followed {
        let class = self.class(bank, 0..0);
        Followed {
            f_k_per_k: class.r_k_per_w,
            se_k_per_k: class.se_k_per_w,
            steady_gain_k_per_k: class.steady_gain_k_per_w,
            se_steady_gain_k_per_k: class.se_steady_gain_k_per_w,
        }
    }

    fn se(&self, term: usize) -> f64 {
        self.covariance[(term, term)].max(0.0).sqrt()
    }
}

/// Sum of what a bank's parameters weigh, feed-through included, and its variance.
pub fn steady_gain(terms: &[ModelTerm], theta: &DVector<f64>, covariance: &DMatrix<f64>, bank: usize) -> (f64, f64) {
    let its: Vec<usize> = (0..terms.len()).filter(|&term| terms[term].role.bank() == Some(bank)).collect();
    let pairs = its.iter().flat_map(|&i| its.iter().map(move |&j| (i, j)));
    let variance: f64 = pairs.map(|at| covariance[at]).sum();
    (its.iter().map(|&term| theta[term]).sum(), variance.max(0.0))
}
