//! Kernel of the sums over all rows, for given weights: the whole data set in one call compiled for the machine's vectors.

use pulp::{Simd, WithSimd};

use super::super::aligned::Aligned;
use super::super::lanes::Real;
use super::super::topology::{Layer, Topology};
use super::normal::{Jacobian, Sums, add_products};
use super::panel::{Panel, Panels, VECTORS};
use super::pass::{
    Column, accumulate, activate, carry_back, columns, columns_mut, cross_entropy, residuals,
    through_activation, weighted_sums,
};

/// Panels whose derivatives are summed in the kernel's precision before the sums go on in double precision.
///
/// A lane then adds at most 256 values, so that sums in `f32` lose no more than some 1e-6 of their terms however
/// many rows there are.
const PANELS_IN_A_ROW: usize = 64;

/// Memory of a pass over one panel and of the sums.
#[derive(Debug, Clone)]
pub(super) struct Tape<T> {
    layers: Vec<Layer>,
    /// Per layer of weights: the values of all neurons for all rows of a panel.
    values: Vec<Aligned<T>>,
    /// Per layer of weights: derivatives with respect to the neurons' sums.
    deltas: Vec<Aligned<T>>,
    /// One vector a weight.
    accumulators: Aligned<T>,
    /// Sums over all rows, one a weight.
    pub(super) totals: Vec<f64>,
    /// Whether the outputs are scores of classes.
    pub(super) softmax: bool,
    /// Sum of the cross-entropies so far.
    entropy: f64,
}

impl<T: Real> Tape<T> {
    pub(super) fn new(topology: &Topology, width: usize) -> Self {
        let room = |neurons: &usize| Aligned::zeros(neurons * VECTORS * width);
        let layers: Vec<Layer> = topology.layers().collect();
        Self {
            values: topology.sizes()[1..].iter().map(room).collect(),
            deltas: topology.sizes()[1..].iter().map(room).collect(),
            accumulators: Aligned::zeros(topology.weights() * width),
            totals: vec![0.0; topology.weights()],
            softmax: false,
            entropy: 0.0,
            layers,
        }
    }
}

/// What is wanted of the rows.
pub(super) enum Wanted<'a, T> {
    /// The sum of squared residuals.
    Error,
    /// That and, in [`Tape::totals`], its derivatives by the weights, halved.
    Gradient,
    /// That and the products of the Jacobian, added to the sums.
    Normal(&'a mut Jacobian<T>, Sums<'a>),
}

/// A pass over all rows; yields the sum of squared residuals.
pub(super) struct AllRows<'a, T> {
    pub(super) panels: &'a Panels<T>,
    pub(super) tape: &'a mut Tape<T>,
    pub(super) weights: &'a [T],
    pub(super) wanted: Wanted<'a, T>,
}

impl<T: Real> WithSimd for AllRows<'_, T> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { panels, tape, weights, mut wanted } = self;
        let mut sum = 0.0;
        tape.totals.fill(0.0);
        tape.entropy = 0.0;
        let at_once = if matches!(wanted, Wanted::Normal(..)) { 1 } else { PANELS_IN_A_ROW };
        for some in panels.panels.chunks(at_once) {
            let mut squares = T::splat(simd, T::of(0.0));
            if let Wanted::Gradient = wanted {
                tape.accumulators.get_mut().fill(T::of(0.0));
            }
            for panel in some {
                let work = One { simd, panels, panel, weights };
                match panel.vectors {
                    1 => work.run::<1>(tape, &mut squares, &mut wanted),
                    2 => work.run::<2>(tape, &mut squares, &mut wanted),
                    3 => work.run::<3>(tape, &mut squares, &mut wanted),
                    _ => work.run::<VECTORS>(tape, &mut squares, &mut wanted),
                }
            }
            sum += T::total(simd, squares).double();
            if let Wanted::Gradient = wanted {
                let vectors = T::vectors::<S>(tape.accumulators.get());
                for (total, &vector) in tape.totals.iter_mut().zip(vectors) {
                    *total += T::total(simd, vector).double();
                }
            }
        }
        if let Wanted::Normal(jacobian, sums) = &mut wanted {
            add_products::<T, S>(simd, jacobian, sums);
        }
        sum + tape.entropy
    }
}

/// A pass over one panel.
struct One<'a, T, S> {
    simd: S,
    panels: &'a Panels<T>,
    panel: &'a Panel,
    weights: &'a [T],
}

impl<T: Real, S: Simd> One<'_, T, S> {
    #[inline(always)]
    fn run<const K: usize>(
        self,
        tape: &mut Tape<T>,
        squares: &mut T::Vector<S>,
        wanted: &mut Wanted<'_, T>,
    ) {
        let inputs = self.forward::<K>(tape, squares);
        match wanted {
            Wanted::Error => {}
            Wanted::Gradient => self.backward::<K>(tape, inputs, None),
            Wanted::Normal(jacobian, sums) => self.derivatives::<K>(tape, inputs, jacobian, sums),
        }
    }

    /// Weights of the lanes of the last vector where some are empty.
    #[inline(always)]
    fn mask(&self) -> Option<T::Vector<S>> {
        if !self.panel.ragged {
            return None;
        }
        T::vectors::<S>(self.panels.mask.get()).first().copied()
    }

    /// Computes all neurons and leaves the residuals as deltas of the last layer; returns the panel's inputs.
    #[inline(always)]
    fn forward<const K: usize>(
        &self,
        tape: &mut Tape<T>,
        squares: &mut T::Vector<S>,
    ) -> &[Column<T, S, K>] {
        let simd = self.simd;
        let width = self.panels.mask.get().len();
        let data = columns::<T, S, K>(&self.panels.values.get()[self.panel.start..]);
        let (inputs, rest) = data.split_at(tape.layers[0].from);
        for (at, layer) in tape.layers.iter().enumerate() {
            let (before, after) = tape.values.split_at_mut(at);
            let used = layer.to * K * width;
            let to = &mut after[0].get_mut()[..used];
            let layer_weights = &self.weights[layer.start..layer.end()];
            let from = match before.last() {
                None => inputs,
                Some(values) => &columns::<T, S, K>(values.get())[..layer.from],
            };
            weighted_sums(simd, layer_weights, from, columns_mut::<T, S, K>(to));
            activate::<T, S>(simd, layer.activation, to);
        }
        let last = tape.layers.len() - 1;
        if tape.softmax {
            let lanes = K * width;
            let mut full = lanes;
            if self.panel.ragged {
                let rows = self.panels.mask.get().iter().filter(|lane| lane.double() > 0.0);
                full = lanes - width + rows.count();
            }
            let targets = self.panel.start + tape.layers[0].from * lanes;
            let used = tape.layers[last].to * lanes;
            let (scores, targets) =
                (&tape.values[last].get()[..used], &self.panels.values.get()[targets..][..used]);
            let deltas = &mut tape.deltas[last].get_mut()[..used];
            tape.entropy += cross_entropy([scores, targets], deltas, lanes, full);
            return inputs;
        }
        let outputs = columns::<T, S, K>(tape.values[last].get());
        let targets = &rest[..tape.layers[last].to];
        let deltas = columns_mut::<T, S, K>(tape.deltas[last].get_mut());
        residuals::<T, S, K>(simd, [outputs, targets], self.mask(), deltas, squares);
        inputs
    }

    /// Carries the deltas of the last layer back to the weights: their products with the values before are summed up, or kept as
    /// rows of the Jacobian where there is one.
    #[inline(always)]
    fn backward<const K: usize>(
        &self,
        tape: &mut Tape<T>,
        inputs: &[Column<T, S, K>],
        mut jacobian: Option<&mut Jacobian<T>>,
    ) {
        let simd = self.simd;
        let width = self.panels.mask.get().len();
        for (at, &layer) in tape.layers.iter().enumerate().rev() {
            let (before, after) = tape.deltas.split_at_mut(at);
            let used = layer.to * K * width;
            let deltas = &mut after[0].get_mut()[..used];
            let values = &tape.values[at].get()[..used];
            through_activation::<T, S>(simd, layer.activation, values, deltas);
            let deltas = columns::<T, S, K>(deltas);
            let from = match at.checked_sub(1) {
                None => inputs,
                Some(previous) => &columns::<T, S, K>(tape.values[previous].get())[..layer.from],
            };
            match &mut jacobian {
                Some(jacobian) => jacobian.write::<S, K>(simd, layer, deltas, from),
                None => {
                    let sums = T::vectors_mut::<S>(tape.accumulators.get_mut());
                    let sums = &mut sums[layer.start..layer.end()];
                    accumulate::<T, S, K>(simd, deltas, from, sums);
                }
            }
            if let Some(place) = before.last_mut() {
                let place = &mut columns_mut::<T, S, K>(place.get_mut())[..layer.from];
                carry_back::<T, S, K>(simd, layer, self.weights, deltas, place);
            }
        }
    }

    /// Adds the derivatives of the panel's residuals to the Jacobian, output by output.
    #[inline(always)]
    fn derivatives<const K: usize>(
        &self,
        tape: &mut Tape<T>,
        inputs: &[Column<T, S, K>],
        jacobian: &mut Jacobian<T>,
        sums: &mut Sums<'_>,
    ) {
        let zero = T::splat(self.simd, T::of(0.0));
        let mut single = [T::splat(self.simd, T::of(1.0)); K];
        if let Some(mask) = self.mask() {
            single[K - 1] = mask;
        }
        let last = tape.layers.len() - 1;
        let outputs = tape.layers[last].to;
        let errors = tape.deltas[last].clone();
        for output in 0..outputs {
            if !jacobian.has_room(K) {
                add_products::<T, S>(self.simd, jacobian, sums);
            }
            let deltas = columns_mut::<T, S, K>(tape.deltas[last].get_mut());
            for (place, delta) in deltas[..outputs].iter_mut().enumerate() {
                *delta = if place == output { single } else { [zero; K] };
            }
            self.backward::<K>(tape, inputs, Some(jacobian));
            jacobian.advance::<S, K>(&columns::<T, S, K>(errors.get())[output]);
        }
    }
}
