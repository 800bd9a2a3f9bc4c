//! Writes the height profile of a simulated surface to standard output: Ra 1.6 um, RSm 200 um, 4 mm long, tilted by
//! 1 um/mm, with 10 nm of noise. `docs/profile.csv` is its output.
#![expect(clippy::print_stdout, reason = "an example that prints")]

use grip_sim::surface::Surface;

fn main() {
    let mut surface = Surface::new(1.2e-6, 130e-6, 4);
    let mut seed = 1_u32;
    let mut uniform = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24) - 0.5
    };
    println!("x_mm,height_um");
    for i in 0..4000_u32 {
        let x_mm = f64::from(i) * 1e-3;
        let noise_um = 0.01 * (0..12).map(|_| uniform()).sum::<f64>();
        println!("{x_mm:.3},{:.3}", 1e6 * surface.height(1e-3 * x_mm) + x_mm + noise_um);
    }
}
