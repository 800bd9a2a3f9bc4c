// An RP2040 from a UF2 file: codes for its converter in, its USB serial port on standard input and output, a summary out.
//
//   node emulator.mjs MODULES FIRMWARE.uf2 CODES SUMMARY.json TIME [adxl345 [FAULT FROM TO]]
//
// MODULES is the folder node_modules with rp2040js. CODES holds 16-bit little-endian codes, one a conversion; after the last
// one the last stays, 50 ms go by, and the emulator ends. SUMMARY gets the cycles between the edges of GP2 (one entry a
// sample), the edges of the LED (GP25), and the deepest stack pointer. TIME gets the emulated time in us, 8 bytes little-endian, by
// which the host at the other end lives. With adxl345 the codes are steps of that sensor, one a reading; FAULT is one of
// those of adxl345.mjs, or `stall`, in which the core stands still, from FROM to TO (ms). No boot ROM: the vector table of the image is taken at once.
import { openSync, readFileSync, writeFileSync, writeSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { Adxl345 } from './adxl345.mjs';

const [modules, uf2File, codesFile, summaryFile, timeFile, sensor, kind, from, to] = process.argv.slice(2);
const { RP2040, USBCDC, GPIOPinState, SimulationClock } = await import(pathToFileURL(`${modules}/rp2040js/dist/esm/index.js`).href).then(
  async (all) => ({ ...all, ...(await import(pathToFileURL(`${modules}/rp2040js/dist/esm/clock/simulation-clock.js`).href)) }));

const FLASH = 0x10000000, VECTORS = 0x10000100, COMPUTING = 2, LED = 25, CYCLE_NS = 8;
const clock = new SimulationClock();
const chip = new RP2040(clock);
const quiet = () => {};
chip.logger = { debug: quiet, info: quiet, warn: quiet, error: (from, words) => console.error(from, words) };

const uf2 = readFileSync(uf2File);
for (let at = 0; at < uf2.length; at += 512) {
  if (uf2.readUInt32LE(at) !== 0x0a324655 || uf2.readUInt32LE(at + 508) !== 0x0ab16f30) throw new Error(`no UF2 block at ${at}`);
  chip.flash.set(uf2.subarray(at + 32, at + 32 + uf2.readUInt32LE(at + 16)), uf2.readUInt32LE(at + 12) - FLASH);
}
chip.core.VTOR = VECTORS;
chip.core.SP = chip.readUint32(VECTORS);
chip.core.PC = chip.readUint32(VECTORS + 4) & ~1;

const bytes = readFileSync(codesFile);
const codes = new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.length >> 1);
let converted = 0;
const adc = chip.adc;
adc.onADCRead = (channel) => {
  adc.currentChannel = channel;
  adc.channelValues[channel] = codes[Math.min(converted, codes.length - 1)];
  converted += 1;
  adc.sampleAlarm.schedule(adc.sampleTime * 1000);
};

// rp2040js 1.4 leaves the interrupt pending when the queue of the converter is read empty.
const read = adc.readUint32.bind(adc);
adc.readUint32 = (offset) => {
  const value = read(offset);
  adc.checkInterrupts();
  return value;
};

const fault = kind ? { kind, from: from * 1e6, to: to * 1e6 } : null;
const values = new Int16Array(bytes.buffer, bytes.byteOffset, bytes.length >> 1);
const chipOnBus = sensor === 'adxl345' ? new Adxl345(chip, clock, values, fault) : null;
const taken = () => chipOnBus ? chipOnBus.converted : converted;

const samples = [], led = [];
let risen = 0;
chip.gpio[COMPUTING].addListener((state) => {
  if (state === GPIOPinState.High) risen = chip.core.cycles;
  else if (risen) samples.push(chip.core.cycles - risen);
});
chip.gpio[LED].addListener((state) => led.push([state === GPIOPinState.High ? 1 : 0, clock.nanos / 1e6]));

const cdc = new USBCDC(chip.usbCtrl);
let connected = false;
cdc.onDeviceConnected = () => { connected = true; };
cdc.onSerialData = (data) => process.stdout.write(Buffer.from(data));
// The firmware makes its endpoint for data ready before it is configured, which the USBCDC of rp2040js does not expect.
let armed = null;
chip.usbCtrl.onEndpointRead = (endpoint, size) => { if (endpoint !== 0) armed = { endpoint, size }; };
const input = [], time = Buffer.alloc(8), clockFile = openSync(timeFile, 'w');
process.stdin.on('data', (data) => input.push(...data));
process.stdin.on('end', () => {});

let stack = chip.core.SP, end = Infinity, interrupted = false;
const top = stack;
process.on('SIGTERM', () => { interrupted = true; });
function burst() {
  for (let i = 0; i < 200000; i++) {
    if (fault?.kind === 'stall' && clock.nanos >= fault.from && clock.nanos < fault.to) clock.tick(1000);
    else if (chip.core.waiting) clock.tick(clock.nanosToNextAlarm);
    else clock.tick(chip.core.executeInstruction() * CYCLE_NS);
    if (chip.core.SP < stack) stack = chip.core.SP;
  }
  if (connected && armed && input.length > 0) {
    const { endpoint, size } = armed;
    armed = null;
    chip.usbCtrl.endpointReadDone(endpoint, Uint8Array.from(input.splice(0, size)));
  }
  time.writeBigUInt64LE(BigInt(Math.floor(clock.nanos / 1000)));
  writeSync(clockFile, time, 0, 8, 0);
  if (end === Infinity && taken() >= codes.length) end = clock.nanos + 50e6;
  if (clock.nanos < end && !interrupted) return void setImmediate(burst);
  writeFileSync(summaryFile, JSON.stringify({
    converted: taken(), lost: chipOnBus?.lost ?? 0, samples, led, stack_bytes: top - stack, cycles: chip.core.cycles, seconds: clock.nanos / 1e9, connected,
  }));
  process.exit(connected ? 0 : 1);
}
burst();
