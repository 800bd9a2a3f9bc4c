//! The C device side under protocol/c against this crate: the same scripts and bytes in, the same lines out.

#[cfg(test)]
mod decode;
#[cfg(test)]
mod device;
#[cfg(test)]
mod peer;
#[cfg(test)]
mod script;
