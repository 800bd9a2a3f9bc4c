//! Tests of the link as its users see it.

#[cfg(test)]
mod clock;
#[cfg(test)]
mod force;
#[cfg(test)]
mod golden;
#[cfg(test)]
mod line;
#[cfg(test)]
mod messages;
#[cfg(test)]
mod session;
#[cfg(test)]
mod sizes;
#[cfg(test)]
mod stream;
