//! Piezo on GP26 at 10 kHz, or an ADXL345 on SPI0 at 3.2 kHz (feature `adxl345`), LED on a slip, the link over USB: the firmware of an RP2040.
#![no_std]
#![no_main]

#[cfg(not(feature = "adxl345"))]
mod converter;
mod soft;

use core::{mem::MaybeUninit, panic::PanicInfo};
use cortex_m_rt::entry;
use rp2040_hal::{
    Sio, Timer, Watchdog, clocks::init_clocks_and_plls, gpio::Pins, pac, rosc::RingOscillator,
    usb::UsbBus,
};
use slip_rp2040::{
    detector::Detector,
    end::End,
    notice,
    sensor::{Sensor, Source},
};
use usb_device::{
    bus::UsbBusAllocator,
    device::{StringDescriptors, UsbDeviceBuilder, UsbVidPid},
};
use usbd_serial::{SerialPort, USB_CLASS_CDC};
#[cfg(feature = "adxl345")]
use {
    embedded_hal::spi::MODE_3,
    rp2040_hal::{
        Clock,
        fugit::RateExtU32,
        gpio::{FunctionSpi, PinState},
        spi::Spi,
    },
    slip_rp2040::adxl345::Adxl345,
};

/// Sets the flash chip of a Raspberry Pi Pico up.
#[unsafe(link_section = ".boot2")]
#[used]
static BOOT2: [u8; 256] = rp2040_boot2::BOOT_LOADER_W25Q080;

#[cfg(feature = "adxl345")]
const SENSOR: &Sensor = &slip_rp2040::sensor::ADXL345;
#[cfg(not(feature = "adxl345"))]
const SENSOR: &Sensor = &slip_rp2040::sensor::PIEZO;

/// Crystal of the board (Hz).
const CRYSTAL_HZ: u32 = 12_000_000;
/// Clock of the ADXL345, at most 5 MHz (Hz).
#[cfg(feature = "adxl345")]
const BUS_HZ: u32 = 5_000_000;
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
    Some(place.write(Detector::new(SENSOR).ok()?))
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

    let mut end = End::new(boot_id, SENSOR).ok()?;
    let mut dark_at = 0;
    #[cfg(not(feature = "adxl345"))]
    let mut source =
        converter::start(pac.ADC, pins.gpio26, &mut pac.RESETS, timer.get_counter().ticks())?;
    #[cfg(feature = "adxl345")]
    let mut source = {
        let wires = (
            pins.gpio19.into_function::<FunctionSpi>(),
            pins.gpio16.into_function::<FunctionSpi>(),
            pins.gpio18.into_function::<FunctionSpi>(),
        );
        let bus = Spi::<_, _, _, 8>::new(pac.SPI0, wires).init(
            &mut pac.RESETS,
            clocks.peripheral_clock.freq(),
            BUS_HZ.Hz(),
            MODE_3,
        );
        let select = pins.gpio17.into_push_pull_output_in_state(PinState::High);
        Adxl345::new(bus, select, pins.gpio20.into_pull_down_input(), timer)
    };
    loop {
        let now = timer.get_counter().ticks();
        let mut bytes = [0; 64];
        let count =
            if device.poll(&mut [&mut serial]) { serial.read(&mut bytes).unwrap_or(0) } else { 0 };
        end.receive(now, bytes.get(..count).unwrap_or(&[]));

        // A clock of its own: readings that a stall since `now` lost would not be counted.
        if let Some(trouble) = source.look(timer.get_counter().ticks()) {
            end.trouble(now, trouble);
        }
        // At most one sample of the detector between two looks at the port.
        for _ in 0..SENSOR.readings_a_sample {
            let Some(reading) = source.next() else { break };
            end.reading(reading.tick_us, reading.value);
            let Some(sample) = detector.reading(reading.index, reading.value) else { continue };
            set(&mut computing, true);
            let slip = detector.sample(&sample);
            set(&mut computing, false);
            if let Some(slip) = slip {
                dark_at = now + LED_US;
                end.line(notice::line(&slip));
            }
            break;
        }
        // It blinks, 131 ms on and as long off, while the sensor delivers nothing.
        let blink = source.is_dead() && now & (1 << 17) != 0;
        set(&mut led, blink || now < dark_at);

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
