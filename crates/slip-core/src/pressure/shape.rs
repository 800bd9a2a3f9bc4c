//! Frames in; the shape they share, and how far a frame departs from it, out.

/// Most that one taxel counts: deviations squared.
pub(super) const CLIP: f32 = 36.0;
/// Frames whose plain mean begins the shape.
const FIRST: f32 = 2.0;

/// A unit vector without mean that follows the frames.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape<const N: usize> {
    u: [f32; N],
    uu: f32,
    frames: f32,
}

/// What a frame shows beside the shape.
#[derive(Clone, Copy, Debug)]
pub(super) struct Departure<const N: usize> {
    residual: [f32; N],
    len: usize,
}

impl<const N: usize> Departure<N> {
    /// A residual for each taxel (unit of the taxels).
    pub(super) fn residual(&self) -> &[f32] {
        self.residual.get(..self.len).unwrap_or(&self.residual)
    }

    fn squares(&self) -> f32 {
        self.residual().iter().map(|r| r * r).sum()
    }

    /// Mean square over the taxels that are free.
    pub(super) fn mean_square(&self) -> f32 {
        self.squares() / (count(self.len) - 2.0).max(1.0)
    }

    /// Mean square over all taxels.
    pub(super) fn over_all(&self) -> f32 {
        self.squares() / count(self.len)
    }

    /// Mean of the squares over the variance, each limited to [`CLIP`].
    pub(super) fn energy(&self, per_variance: f32) -> f32 {
        let sum: f32 = self.residual().iter().map(|r| (r * r * per_variance).min(CLIP)).sum();
        sum / count(self.len)
    }
}

impl<const N: usize> Shape<N> {
    pub(super) const fn new() -> Self {
        Self { u: [0.0; N], uu: 0.0, frames: 0.0 }
    }

    /// Compares the frame and follows it by the time `dt_over_tau`; `None` for the first frame and for one without a pattern.
    pub(super) fn step(
        &mut self,
        frame: &[f32; N],
        n: usize,
        dt_over_tau: f32,
    ) -> Option<Departure<N>> {
        let (p, norm) = centred(frame, n);
        if norm <= 0.0 {
            return None;
        }
        let before = (self.frames > 0.0).then(|| self.residual(&p, n));
        self.frames = (self.frames + 1.0).min(FIRST + 1.0);
        let follow = 1.0 - libm::expf(-dt_over_tau);
        let weight = if self.frames <= FIRST { 1.0 / self.frames } else { follow };
        let scale = 1.0 / norm;
        for (u, p) in self.u.iter_mut().zip(&p).take(n) {
            *u += weight * (p * scale - *u);
        }
        self.uu = self.u.iter().take(n).map(|u| u * u).sum();
        before.map(|residual| Departure { residual, len: n })
    }

    /// The frame of `n` taxels without its share of the shape.
    fn residual(&self, p: &[f32; N], n: usize) -> [f32; N] {
        let dot: f32 = p.iter().zip(&self.u).take(n).map(|(p, u)| p * u).sum();
        let share = if self.uu > 0.0 { dot / self.uu } else { 0.0 };
        let mut out = [0.0; N];
        for (r, (p, u)) in out.iter_mut().zip(p.iter().zip(&self.u)).take(n) {
            *r = p - share * u;
        }
        out
    }
}

/// The first `n` taxels less their mean, the rest zero; and the length of that vector.
fn centred<const N: usize>(frame: &[f32; N], n: usize) -> ([f32; N], f32) {
    let mean = frame.iter().take(n).sum::<f32>() / count(n);
    let mut p = [0.0; N];
    for (p, value) in p.iter_mut().zip(frame).take(n) {
        *p = value - mean;
    }
    let norm = libm::sqrtf(p.iter().take(n).map(|p| p * p).sum());
    (p, norm)
}

#[expect(clippy::cast_precision_loss, reason = "at most some hundred taxels")]
pub(super) fn count(n: usize) -> f32 {
    n.max(1) as f32
}

/// Mean of residuals at rest without the largest of them, so that one knock does not raise the noise.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Spread {
    sum: f32,
    largest: f32,
    count: u16,
}

impl Spread {
    pub(super) fn push(&mut self, mean_square: f32) {
        self.sum += mean_square;
        self.largest = self.largest.max(mean_square);
        self.count = self.count.saturating_add(1);
    }

    /// The mean once there are `frames` residuals.
    pub(super) fn mean(&self, frames: u16) -> Option<f32> {
        (self.count >= frames.max(2))
            .then(|| (self.sum - self.largest).max(0.0) / f32::from(self.count - 1))
    }
}
