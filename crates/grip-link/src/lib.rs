//! grip-link
#![no_std]
