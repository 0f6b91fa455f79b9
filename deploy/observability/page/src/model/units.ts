// Values with the units that panels of Grafana name.

// The largest unit that leaves at least 1; the last one is the smallest.
function scaled(value: number, units: [number, string][]): string {
  const size = Math.abs(value);
  const [factor, name] = units.find(([each]) => size >= each) ??
    units[units.length - 1]!;
  return `${digits(value / factor)} ${name}`;
}

// Three digits that count.
function digits(value: number): string {
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1000) return value.toFixed(0);
  return String(Number(value.toPrecision(3)));
}

export function withUnit(value: number, unit: string): string {
  switch (unit) {
    case 's':
      return value === 0 ? '0 s' :
        scaled(value, [[1, 's'], [1e-3, 'ms'], [1e-6, 'µs']]);
    case 'bytes':
      return scaled(value, [[2 ** 30, 'GiB'], [2 ** 20, 'MiB'],
        [2 ** 10, 'KiB'], [1, 'B']]);
    case 'percentunit': return `${digits(100 * value)} %`;
    case 'reqps':
    case 'ops': return `${digits(value)}/s`;
    default: return digits(value);
  }
}
