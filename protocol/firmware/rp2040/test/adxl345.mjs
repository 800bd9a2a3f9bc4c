// An ADXL345 on SPI0 of an emulated RP2040: CS on GP17, INT1 on GP20. Registers, queue and watermark as in its data sheet.
//
// It refuses a bus in another mode than 3, above 5 MHz, or below 2 MHz, and a read of the queue less than 5 us after the one before.
const CS = 17, INT1 = 20, ROOM = 32;
const ID = 0x00, POWER_CTL = 0x2d, BW_RATE = 0x2c, INT_ENABLE = 0x2e, INT_SOURCE = 0x30, DATA_FORMAT = 0x31, DATA = 0x32, FIFO_CTL = 0x38, FIFO_STATUS = 0x39;
const PERIOD_NS = 312500;

export class Adxl345 {
  // values: the x axis, one a reading; the last one stays. fault: 'id', 'zeros', 'ones' or 'power', between two times (ns), or null.
  constructor(chip, clock, values, fault) {
    Object.assign(this, { chip, clock, values, fault, converted: 0, lost: 0, queue: [], registers: new Uint8Array(64), overrun: false });
    this.reset();
    this.latch = [0, 0, 0, 0, 0, 0];
    this.at = -1;
    this.readNs = -Infinity;
    this.wasPower = false;
    chip.gpio[CS].addListener(() => { this.at = -1; });
    const spi = chip.spi[0];
    let answer = 0;
    const done = clock.createAlarm(() => spi.completeTransmit(answer));
    spi.onTransmit = (byte) => {
      // Bits 6 and 7, polarity and phase: spiMode of rp2040js 1.4 takes modes 2 and 3 for each other.
      if ((spi.control0 & 0xc0) !== 0xc0 || spi.clockFrequency > 5e6 || spi.clockFrequency < 2e6 || spi.dataBits !== 8) {
        throw new Error(`SPI control ${spi.control0}, ${spi.clockFrequency} Hz, ${spi.dataBits} bits`);
      }
      answer = chip.gpio[CS].outputValue ? 0xff : this.byte(byte);
      if (this.active('zeros')) answer = 0;
      if (this.active('ones')) answer = 0xff;
      done.schedule(8e9 / spi.clockFrequency);
    };
    const tick = clock.createAlarm(() => { tick.schedule(PERIOD_NS); this.convert(); });
    tick.schedule(PERIOD_NS);
  }

  reset() {
    this.registers.fill(0);
    this.registers[BW_RATE] = 0x0a;
    this.queue = [];
    this.overrun = false;
  }

  active(kind) {
    return this.fault?.kind === kind && this.clock.nanos >= this.fault.from && this.clock.nanos < this.fault.to;
  }

  convert() {
    const r = this.registers;
    // The supply drops for a moment: everything set is gone.
    if (this.active('power') !== this.wasPower) { this.wasPower = !this.wasPower; this.reset(); }
    if ((r[POWER_CTL] & 0x08) === 0) return;
    if (r[BW_RATE] !== 0x0f || r[DATA_FORMAT] !== 0x0b || r[FIFO_CTL] >> 6 !== 2) throw new Error(`registers ${r.slice(0x2c)}`);
    if (this.queue.length === ROOM) { this.queue.shift(); this.overrun = true; this.lost += 1; }
    this.queue.push(this.values[Math.min(this.converted, this.values.length - 1)]);
    this.converted += 1;
    this.lines();
  }

  lines() {
    const mark = this.registers[FIFO_CTL] & 0x1f;
    this.chip.gpio[INT1].setInputValue((this.registers[INT_ENABLE] & 2) !== 0 && this.queue.length >= mark);
  }

  byte(byte) {
    if (this.at < 0) {
      this.reads = (byte & 0x80) !== 0;
      this.more = (byte & 0x40) !== 0;
      this.at = byte & 0x3f;
      if (this.reads && this.at === DATA) this.take();
      return 0;
    }
    const at = this.at;
    if (this.more) this.at += 1;
    if (this.reads) return this.value(at);
    this.registers[at] = byte;
    // Bypass empties the queue.
    if (at === FIFO_CTL && byte >> 6 === 0) { this.queue = []; this.overrun = false; }
    this.lines();
    return 0;
  }

  take() {
    if (this.clock.nanos - this.readNs < 5000) throw new Error('the queue was read less than 5 us after the read before');
    if (this.queue.length > 0) {
      const x = this.queue.shift(), z = 256;
      this.latch = [x & 0xff, x >> 8 & 0xff, 0, 0, z & 0xff, z >> 8];
    }
    this.overrun = false;
    this.lines();
  }

  value(at) {
    if (at === ID) return this.active('id') ? 0xe4 : 0xe5;
    if (at >= DATA && at < DATA + 6) {
      this.readNs = this.clock.nanos;
      return this.latch[at - DATA];
    }
    if (at === INT_SOURCE) return (this.queue.length > 0 ? 0x80 : 0) | (this.overrun ? 1 : 0);
    if (at === FIFO_STATUS) return this.queue.length;
    return this.registers[at];
  }
}
