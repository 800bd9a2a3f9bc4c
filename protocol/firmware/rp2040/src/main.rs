//! Piezo on GP26 at 10 kHz, LED on a slip, the link over USB: the firmware of an RP2040.
#![no_std]
#![no_main]

mod converter;
mod soft;

use core::{mem::MaybeUninit, panic::PanicInfo};
use cortex_m_rt::entry;
use rp2040_hal::{
    Sio, Timer, Watchdog, clocks::init_clocks_and_plls, gpio::Pins, pac, rosc::RingOscillator,
    usb::UsbBus,
};
use slip_rp2040::{
    detector::{Detector, PERIOD_US, READINGS_A_SAMPLE},
    end::End,
    notice,
};
use usb_device::{
    bus::UsbBusAllocator,
    device::{StringDescriptors, UsbDeviceBuilder, UsbVidPid},
};
use usbd_serial::{SerialPort, USB_CLASS_CDC};

/// Sets the flash chip of a Raspberry Pi Pico up.
#[unsafe(link_section = ".boot2")]
#[used]
static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_W25Q080;

/// Crystal of the board (Hz).
const CRYSTAL_HZ: u32 = 12_000_000;
/// The LED stays on at least so long (us).
const LED_US: u64 = 200_000;

#[entry]
fn main() -> ! {
    static mut DETECTOR: MaybeUninit<Detector> = MaybeUninit::uninit();
    // First, while the stack is free: it takes most of it for a moment. Only what cannot be on a whole chip gets past these lines.
    let _ = make(DETECTOR).and_then(run);
    loop {
        core::hint::spin_loop();
    }
}

#[inline(never)]
fn make(place: &mut MaybeUninit<Detector>) -> Option<&mut Detector> {
    Some(place.write(Detector::new().ok()?))
}

#[inline(never)]
fn run(detector: &mut Detector) -> Option<()> {
    let mut pac = pac::Peripherals::take()?;
    let mut watchdog = Watchdog::new(pac.WATCHDOG);
    let clocks = init_clocks_and_plls(
        CRYSTAL_HZ,
        pac.XOSC,
        pac.CLOCKS,
        pac.PLL_SYS,
        pac.PLL_USB,
        &mut pac.RESETS,
        &mut watchdog,
    )
    .ok()?;
    let sio = Sio::new(pac.SIO);
    let pins = Pins::new(pac.IO_BANK0, pac.PADS_BANK0, sio.gpio_bank0, &mut pac.RESETS);
    let mut led = pins.gpio25.into_push_pull_output();
    // High while the detector computes: an oscilloscope or the emulator sees its time.
    let mut computing = pins.gpio2.into_push_pull_output();
    let timer = Timer::new(pac.TIMER, &mut pac.RESETS, &clocks);

    let rosc = RingOscillator::new(pac.ROSC).initialize();
    let boot_id = (0..64).fold(timer.get_counter_low() | 1, |id, _| {
        id.rotate_left(1) ^ u32::from(rosc.get_random_bit())
    });
    let bus = UsbBusAllocator::new(UsbBus::new(
        pac.USBCTRL_REGS,
        pac.USBCTRL_DPRAM,
        clocks.usb_clock,
        true,
        &mut pac.RESETS,
    ));
    let mut serial = SerialPort::new(&bus);
    // The number that the Raspberry Pi foundation's SDK uses for a serial port.
    let mut device = UsbDeviceBuilder::new(&bus, UsbVidPid(0x2E8A, 0x000A))
        .strings(&[StringDescriptors::default().product("slip detector")])
        .ok()?
        .max_packet_size_0(64)
        .ok()?
        .device_class(USB_CLASS_CDC)
        .build();

    let mut end = End::new(boot_id).ok()?;
    let mut dark_at = 0;
    let start = timer.get_counter().ticks();
    converter::start(pac.ADC, pins.gpio26, &mut pac.RESETS)?;
    loop {
        let now = timer.get_counter().ticks();
        let mut bytes = [0; 64];
        let count =
            if device.poll(&mut [&mut serial]) { serial.read(&mut bytes).unwrap_or(0) } else { 0 };
        end.receive(now, bytes.get(..count).unwrap_or(&[]));

        // At most one sample of the detector between two looks at the port.
        for _ in 0..READINGS_A_SAMPLE {
            let Some((index, code)) = converter::next() else { break };
            end.reading(start + index * PERIOD_US, code);
            let Some(sample) = detector.reading(index, code) else { continue };
            set(&mut computing, true);
            let slip = detector.sample(&sample);
            set(&mut computing, false);
            if let Some(slip) = slip {
                dark_at = now + LED_US;
                end.slip(notice::line(&slip));
            }
            break;
        }
        set(&mut led, now < dark_at);

        let waiting = end.waiting(now);
        if !waiting.is_empty() {
            let taken = serial.write(waiting).unwrap_or(0);
            end.sent(taken);
        }
    }
}

fn set(pin: &mut impl embedded_hal::digital::OutputPin, high: bool) {
    // A pin of this chip cannot fail.
    let _ = pin.set_state(high.into());
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
