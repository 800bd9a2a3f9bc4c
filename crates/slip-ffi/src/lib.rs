//! The border to C: slip events and force commands from samples of a gripper, in memory of the caller.
//!
//! C and C++ use `include/slip.h`, which `tests/header.rs` makes from this crate; `docs/c.md` is the guide. Every
//! function checks what it is given, answers with a [`SlipStatus`], and lets no panic out. [`slip_create`] allocates;
//! [`slip_push`] does not.

mod abi;
mod border;
mod clock;
mod pipeline;
mod status;

pub use abi::{
    SlipBlock, SlipEsc, SlipEvent, SlipEventKind, SlipNeed, SlipObject, SlipOptions, SlipResult,
    SlipSignal, SlipState, SlipTrial,
};
pub use pipeline::SlipPipeline;
pub use status::SlipStatus;

use border::{Column, copy_text, guarded, place, text};
use core::{
    ffi::{c_char, c_void},
    ptr,
};
use slip_core::ClientCommand;
use slip_core::esc::{EscSum, Reading};
use std::borrow::Cow;

/// Bytes of memory that a pipeline needs.
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn slip_size() -> usize {
    size_of::<SlipPipeline>()
}

/// Alignment of that memory; what malloc gives has it.
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn slip_align() -> usize {
    align_of::<SlipPipeline>()
}

/// The version of this library, as in "0.1.0".
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn slip_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

/// A sentence for a status; of any other number too.
#[unsafe(no_mangle)]
#[must_use]
pub extern "C" fn slip_error_text(status: i32) -> *const c_char {
    status::sentence(status).as_ptr()
}

/// Makes a pipeline in `memory`, `size` bytes (slip_size() or more, aligned to slip_align()), and sets `*made` to it,
/// or to NULL where that fails.
///
/// Why it fails is written to `why` as a sentence, as far as `why_size` bytes hold it; `why` may be NULL. A pipeline
/// belongs to one thread at a time, must not be copied, and ends with slip_destroy(): one that is still in `memory`
/// leaks. Needs 600 kB of stack. Traps of floating point must be masked, here and in slip_push().
///
/// # Safety
/// Each pointer is NULL or points to what its type names, for as many bytes as given; the texts end with a zero byte.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slip_create(
    memory: *mut c_void,
    size: usize,
    options: *const SlipOptions,
    why: *mut c_char,
    why_size: usize,
    made: *mut *mut SlipPipeline,
) -> SlipStatus {
    let mut sentence = None;
    let status = guarded(|| {
        let made = place(made)?;
        // SAFETY: not null, aligned, and by the caller's word a pointer.
        unsafe { made.write(ptr::null_mut()) };
        let memory: *mut SlipPipeline = place(memory.cast())?;
        let options = place(options.cast_mut())?;
        if size < slip_size() {
            return Err(SlipStatus::Size);
        }
        // SAFETY: not null, aligned, and by the caller's word options.
        let options = unsafe { options.read() };
        // SAFETY: by the caller's word texts that end with a zero byte, or null.
        let texts =
            unsafe { [text(options.settings)?, text(options.calibration)?, text(options.model)?] };
        match SlipPipeline::new(&options, texts, memory) {
            Ok(pipeline) => {
                // SAFETY: not null, aligned, large enough.
                unsafe { memory.write(pipeline) };
                // SAFETY: not null, aligned, and by the caller's word a pointer.
                unsafe { made.write(memory) };
                Ok(())
            }
            Err(why) => {
                sentence = Some(why);
                Err(SlipStatus::Options)
            }
        }
    });
    if status != SlipStatus::Ok {
        let sentence =
            sentence.map_or_else(|| status::sentence(status as i32).to_string_lossy(), Cow::Owned);
        // SAFETY: by the caller's word null or `why_size` bytes.
        unsafe { copy_text(&sentence, why, why_size) };
    }
    status
}

/// Ends a pipeline. Its memory is the caller's again.
///
/// # Safety
/// `pipeline` is NULL or points to slip_size() readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slip_destroy(pipeline: *mut SlipPipeline) -> SlipStatus {
    guarded(|| {
        // SAFETY: as this function asks for.
        let live = unsafe { SlipPipeline::live(pipeline) }?;
        live.end();
        // SAFETY: made by `slip_create`; without its mark nothing uses it again.
        unsafe { pipeline.drop_in_place() };
        Ok(())
    })
}

/// Takes a block of samples in order and fills in `result`. Allocates nothing, takes no lock, reads no clock.
///
/// A block is taken whole or refused whole. SLIP_STATUS_VALUE: a time is not later than that of the row before, so the
/// clock stands or was set back. A jump ahead is a gap; where it was a mistake, only a new slip_create() ends it.
/// `found` and `state` are written in spite of a status, `state` as after the last row that was taken.
///
/// # Safety
/// Each pointer is NULL or points to what its type names: columns to `rows` values, taxels to `rows * taxel_count`,
/// events to `room` of them, statistic and command_n to room for `rows` values. No other thread uses any of it
/// meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slip_push(
    pipeline: *mut SlipPipeline,
    block: *const SlipBlock,
    result: *mut SlipResult,
) -> SlipStatus {
    let status = guarded(|| {
        let result = place(result)?;
        // SAFETY: not null, aligned, by the caller's word a result, and nothing else uses it.
        let result = unsafe { &mut *result };
        result.found = 0;
        // SAFETY: as this function asks for.
        let live = unsafe { SlipPipeline::live(pipeline) }?;
        result.state = live.state;
        let block = place(block.cast_mut())?;
        // SAFETY: not null, aligned, and by the caller's word a block.
        let block = unsafe { block.read() };
        // SAFETY: as this function asks for.
        unsafe { live.push(&block, result) }
    });
    if status == SlipStatus::Panicked {
        // SAFETY: as this function asks for. What a panic has left half done is used no more.
        if let Ok(live) = unsafe { SlipPipeline::live(pipeline) } {
            live.end();
        }
    }
    status
}

/// Asks the controller to hold with at least `force_n`, to let go, to close again, or to grasp the next objects with `force_n`, which they are known to need
/// (SLIP_OPERATION_AT_LEAST, _RELEASE, _GRASP, _EXPECT). A pipeline that only observes does nothing, with SLIP_STATUS_OK.
///
/// # Safety
/// `pipeline` is NULL or points to slip_size() readable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slip_command(
    pipeline: *mut SlipPipeline,
    operation: u8,
    force_n: f32,
) -> SlipStatus {
    guarded(|| {
        // SAFETY: as this function asks for.
        let live = unsafe { SlipPipeline::live(pipeline) }?;
        let command = match operation {
            1 => ClientCommand::AtLeast(force_n),
            2 => ClientCommand::Release,
            3 => ClientCommand::Grasp,
            6 => ClientCommand::Expect(force_n),
            _ => return Err(SlipStatus::Value),
        };
        if live.obey(command) { Ok(()) } else { Err(SlipStatus::Value) }
    })
}

/// Writes to `need` what the object in hand needs, as it was known after the last row.
///
/// # Safety
/// `pipeline` is NULL or points to slip_size() readable bytes, `need` is NULL or points to a slip_need. No other thread uses either meanwhile.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slip_needed(
    pipeline: *mut SlipPipeline,
    need: *mut SlipNeed,
) -> SlipStatus {
    guarded(|| {
        // SAFETY: as this function asks for.
        let live = unsafe { SlipPipeline::live(pipeline) }?;
        // SAFETY: not null, aligned, and by the caller's word room for one.
        unsafe { place(need)?.write(live.need.into()) };
        Ok(())
    })
}

/// E_sc of `n` irregularities of height `delta_m` and spacing `spacing_m`, read as `reading` (SLIP_READING_*).
///
/// # Safety
/// Each pointer is NULL or points to what its type names, `delta_m` and `spacing_m` to `n` values.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn slip_esc(
    delta_m: *const f64,
    spacing_m: *const f64,
    n: usize,
    trial: *const SlipTrial,
    reading: u8,
    value: *mut SlipEsc,
) -> SlipStatus {
    guarded(|| {
        let (delta_m, spacing_m) = (Column::new(delta_m, n)?, Column::new(spacing_m, n)?);
        let trial = place(trial.cast_mut())?;
        let value = place(value)?;
        // SAFETY: not null, aligned, and by the caller's word a trial.
        let trial = unsafe { trial.read() }.into();
        let reading = Reading::from_code(reading);
        if !Reading::ALL.contains(&reading) {
            return Err(SlipStatus::Value);
        }
        let mut sum = EscSum::new(reading);
        for at in 0..n {
            // SAFETY: below `n`.
            let lengths = unsafe { (delta_m.at(at), spacing_m.at(at)) };
            let (Some(delta_m), Some(spacing_m)) = lengths else { return Err(SlipStatus::Null) };
            sum.push(delta_m, spacing_m);
        }
        let esc = sum.chosen(&trial, sum.literal(&trial)).ok_or(SlipStatus::NoValue)?;
        // SAFETY: not null, aligned, and by the caller's word room for one.
        unsafe { value.write(esc.into()) };
        Ok(())
    })
}
