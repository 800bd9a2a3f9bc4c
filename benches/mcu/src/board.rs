//! UART and SysTick of the MPS2 board with the AN386 image.

use core::panic::PanicInfo;

const UART_DATA: *mut u32 = 0x4000_4000 as *mut u32;
const UART_CTRL: *mut u32 = 0x4000_4008 as *mut u32;
const UART_BAUD_DIV: *mut u32 = 0x4000_4010 as *mut u32;
const SYSTICK: *mut u32 = 0xE000_E010 as *mut u32;

/// Instructions in a tick under `-icount shift=0`.
const INSTRUCTIONS: u32 = 40;
const FULL: u32 = 0x00FF_FFFF;

/// The running board.
#[derive(Debug)]
pub struct Board {
    overhead: u32,
}

impl Board {
    /// Starts both blocks and measures what measuring costs.
    pub fn start() -> Self {
        // SAFETY: registers of this board, which nothing else uses.
        unsafe {
            UART_BAUD_DIV.write_volatile(16);
            UART_CTRL.write_volatile(1);
            SYSTICK.add(1).write_volatile(FULL);
            SYSTICK.add(2).write_volatile(0);
            SYSTICK.write_volatile(0b101);
        }
        let empty = Self { overhead: 0 };
        let mut total = 0;
        for _ in 0..4096 {
            total += empty.ticks(|| core::hint::black_box(()));
        }
        // In instructions; the phase of the ticks against the loop averages out.
        Self { overhead: total * INSTRUCTIONS / 4096 }
    }

    /// Prints how many instructions a thousand of them are measured to be.
    pub fn check(&self) {
        let mut sum = 0;
        for _ in 0..1000 {
            // SAFETY: does nothing.
            sum += self.instructions(|| unsafe { core::arch::asm!(".rept 1000", "nop", ".endr") });
        }
        print(&["1000 instructions are measured as ", "\n"], &[sum.unsigned_abs() / 1000]);
    }

    #[inline]
    fn now() -> u32 {
        // SAFETY: reading the counter has no effect.
        unsafe { SYSTICK.add(2).read_volatile() }
    }

    #[inline]
    fn ticks(&self, work: impl FnOnce()) -> u32 {
        let before = Self::now();
        work();
        before.wrapping_sub(Self::now()) & FULL
    }

    /// Instructions that `work` takes, to within a tick; the mean over many calls is finer.
    #[inline]
    pub fn instructions(&self, work: impl FnOnce()) -> i32 {
        (self.ticks(work) * INSTRUCTIONS).cast_signed() - self.overhead.cast_signed()
    }
}

/// Writes texts and numbers in turn: text, number, text, ...
pub fn print(texts: &[&str], numbers: &[u32]) {
    for (place, text) in texts.iter().enumerate() {
        text.bytes().for_each(put);
        if let Some(number) = numbers.get(place) {
            put_number(*number);
        }
    }
}

fn put_number(mut number: u32) {
    let mut digits = [0; 10];
    let mut used = 0;
    for slot in &mut digits {
        *slot = b'0' + u8::try_from(number % 10).unwrap_or(0);
        number /= 10;
        used += 1;
        if number == 0 {
            break;
        }
    }
    digits.iter().take(used).rev().for_each(|&digit| put(digit));
}

fn put(byte: u8) {
    // SAFETY: a register of this board; the emulated port takes every byte at once.
    unsafe { UART_DATA.write_volatile(u32::from(byte)) }
}

/// Nothing more to do; who reads the UART ends the emulator.
pub fn stop() -> ! {
    loop {
        core::hint::spin_loop();
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    print(&["failed\n"], &[]);
    stop()
}
