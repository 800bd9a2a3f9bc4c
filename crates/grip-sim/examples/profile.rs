//! Writes the height profile of a simulated surface to standard output, 8 mm long: roughness of Ra 1.6 um and RSm 150 um on
//! waviness and a bent form, with 10 nm of noise. `docs/profile.csv` is its output.
//!
//! `profile [AMPLITUDE_UM [SEED]]`: amplitude of the strongest of the three waves of its waviness (3 um; 0 for none) and seed
//! of its asperities (4).
#![expect(clippy::print_stdout, reason = "an example that prints")]

use grip_sim::{shape::Shape, surface::Surface};

fn main() {
    let number = |at, usual: f64| {
        let text = std::env::args().nth(at);
        text.map_or(Ok(usual), |text| text.parse()).unwrap_or_else(|_| {
            eprintln!("usage: profile [AMPLITUDE_UM [SEED]]");
            std::process::exit(2)
        })
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a seed")]
    let seed = number(2, 4.0) as u64;
    let shape = Shape {
        amplitude_m: 1e-6 * number(1, 3.0),
        wavelength_m: 2e-3,
        phases: [0.4, 2.0, 5.1],
        tilt: 2e-3,
        curvature_1_m: 0.7,
    };
    let mut surface = Surface::new(1.2e-6, 130e-6, seed).with_shape(shape);
    let mut state = 1_u32;
    let mut uniform = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    println!("x_mm,height_um");
    for i in 0..4000_u32 {
        let x_mm = f64::from(i) * 2e-3;
        let noise_um = 0.01 * (0..12).map(|_| uniform()).sum::<f64>();
        println!("{x_mm:.3},{:.3}", 1e6 * surface.height(1e-3 * x_mm) + noise_um);
    }
}
