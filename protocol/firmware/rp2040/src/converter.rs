//! The converter at 10 kHz into a ring: the interrupt writes, the main loop reads.

use core::sync::atomic::{AtomicU16, AtomicU32, Ordering};
use rp2040_hal::{
    Adc,
    adc::AdcPin,
    gpio::{FunctionNull, Pin, PullDown, bank0::Gpio26},
    pac::{self, interrupt},
};
use slip_rp2040::{
    detector::centred,
    sensor::{PIEZO, Reading, Source, Trouble},
};

/// Readings that may wait: 0.1 s, as long as a busy USB may keep the main loop.
const ROOM: usize = 1024;
/// Clock of the converter (Hz).
const CLOCK_HZ: u32 = 48_000_000;

static RING: [AtomicU16; ROOM] = [const { AtomicU16::new(0) }; ROOM];
/// Readings written, by the interrupt alone, and read, by the main loop alone; both wrap.
static WRITTEN: AtomicU32 = AtomicU32::new(0);
static READ: AtomicU32 = AtomicU32::new(0);

/// The converter, which runs since this time of the board (us).
pub struct Piezo {
    start_us: u64,
}

impl Source for Piezo {
    fn look(&mut self, _: u64) -> Option<Trouble> {
        None
    }

    fn next(&mut self) -> Option<Reading> {
        let (index, code) = next()?;
        let tick_us = self.start_us + PIEZO.time_us(index);
        Some(Reading { index, tick_us, value: centred(code) })
    }

    fn is_dead(&self) -> bool {
        false
    }
}

/// Begins to convert; `None` where the pin is none of the converter.
pub fn start(
    adc: pac::ADC,
    pin: Pin<Gpio26, FunctionNull, PullDown>,
    resets: &mut pac::RESETS,
    start_us: u64,
) -> Option<Piezo> {
    let mut adc = Adc::new(adc, resets);
    let mut pin = AdcPin::new(pin.into_floating_input()).ok()?;
    let divider = u16::try_from(CLOCK_HZ / PIEZO.rate_hz - 1).ok()?;
    // It runs until power goes: to drop its handles stops nothing.
    adc.build_fifo().clock_divider(divider, 0).set_channel(&mut pin).enable_interrupt(1).start();
    // SAFETY: the handler below is in place, and shares only atomics with the main loop.
    unsafe { pac::NVIC::unmask(pac::Interrupt::ADC_IRQ_FIFO) };
    Some(Piezo { start_us })
}

/// The oldest reading that waits, with its number since the start. Where the main loop was late by more than the ring, those
/// that were overwritten are left out.
fn next() -> Option<(u64, u16)> {
    let written = WRITTEN.load(Ordering::Acquire);
    let mut read = READ.load(Ordering::Relaxed);
    let room = ROOM as u32;
    if written == read {
        return None;
    }
    if written.wrapping_sub(read) >= room {
        read = written.wrapping_sub(room / 2);
    }
    let code = RING.get(read as usize % ROOM)?.load(Ordering::Relaxed);
    READ.store(read.wrapping_add(1), Ordering::Relaxed);
    // 119 hours until the number wraps; the detector takes the jump back for samples that are out of order.
    Some((u64::from(read), code))
}

#[interrupt]
fn ADC_IRQ_FIFO() {
    // SAFETY: only this handler touches the converter once it runs; reading the queue's end takes a reading off it.
    let adc = unsafe { &*pac::ADC::PTR };
    while adc.fcs().read().level().bits() > 0 {
        let code = adc.fifo().read().val().bits();
        let written = WRITTEN.load(Ordering::Relaxed);
        if let Some(place) = RING.get(written as usize % ROOM) {
            place.store(code, Ordering::Relaxed);
        }
        WRITTEN.store(written.wrapping_add(1), Ordering::Release);
    }
}
