//! A stretch of sliding of an object as the pipeline measures it: any force from far too light to
//! braking hard, any speed, 4 to 40 ms long.
//!
//! A trial grasp starts from rest with too little force; a gripper that has begun to answer the slip presses
//! harder than needed while the object still slides, and its estimate must hold there too. The impulse balance is
//! the same: a = g (1 - F / F_req) with either sign.

use super::Slip;
use crate::GRAVITY_M_S2;
use crate::random;
use crate::scene::Object;
use rand_chacha::ChaCha8Rng;

/// Mass of the objects (kg): from a paper cup to what a force of 60 N a finger can hold.
pub(super) const MASS_KG: [f64; 2] = [0.03, 4.0];
/// Kinetic friction of the objects.
pub(super) const FRICTION: [f64; 2] = [0.15, 0.9];
/// Force over the needed force.
const SHARE: [f64; 2] = [0.05, 2.2];
/// Length (s).
const TIME_S: [f64; 2] = [0.004, 0.05];
/// Speed at the end (m/s).
const SPEED_M_S: [f64; 2] = [0.002, 0.5];

/// Draws until the object slides forward from the start to the end of the stretch.
pub(super) fn slip(object: Object, rng: &mut ChaCha8Rng) -> Slip {
    loop {
        let force_n = object.force_needed_n() * random::uniform(rng, SHARE[0], SHARE[1]);
        let time_s = random::log_uniform(rng, TIME_S[0], TIME_S[1]);
        let speed_m_s = random::log_uniform(rng, SPEED_M_S[0], SPEED_M_S[1]);
        let gained_m_s = GRAVITY_M_S2 * (1.0 - force_n / object.force_needed_n()) * time_s;
        let first = speed_m_s - gained_m_s;
        if first >= 0.0 {
            let travel_m = 0.5 * (first + speed_m_s) * time_s;
            return Slip { travel_m, speed_m_s, gained_m_s, time_s, force_n, start_m: 0.0 };
        }
    }
}
