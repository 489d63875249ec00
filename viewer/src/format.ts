/** Numbers as a reader wants them. */

export function metres(value: number): string {
  const size = Math.abs(value);
  if (size >= 10_000) return `${(value / 1000).toFixed(1)} km`;
  if (size >= 100) return `${value.toFixed(0)} m`;
  if (size >= 1) return `${value.toFixed(2)} m`;
  if (size >= 0.1) return `${(value * 100).toFixed(0)} cm`;
  return `${(value * 100).toFixed(1)} cm`;
}

export function grouped(value: number): string {
  return Math.round(value)
    .toString()
    .replace(/\B(?=(\d{3})+(?!\d))/g, ",");
}

export function significant(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 100_000 || size < 1e-4) return value.toExponential(digits - 1);
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  const text = value.toFixed(Math.min(8, decimals));
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

/** Minutes and seconds, with hours where there are any. */
export function clock(seconds: number, decimals = 0): string {
  const sign = seconds < 0 ? "-" : "";
  const scale = 10 ** decimals;
  const whole = Math.round(Math.abs(seconds) * scale) / scale;
  const hours = Math.floor(whole / 3600);
  const minutes = Math.floor((whole - 3600 * hours) / 60);
  const rest = whole - 3600 * hours - 60 * minutes;
  const two = (value: number) => String(value).padStart(2, "0");
  const tail = rest.toFixed(decimals).padStart(decimals > 0 ? 3 + decimals : 2, "0");
  return `${sign}${hours > 0 ? `${hours}:${two(minutes)}` : minutes}:${tail}`;
}

export function optional(value: number | null, write: (value: number) => string): string {
  return value === null ? "–" : write(value);
}

export function percent(value: number): string {
  return `${(value * 100).toFixed(0)} %`;
}

/** Seconds of "2:13.4", "1:02:13" or "133.4"; null of anything else. */
export function parseClock(text: string): number | null {
  const parts = text.trim().replace(",", ".").split(":");
  const fits = parts.every((part, i) =>
    i === parts.length - 1 ? /^(\d+\.?\d*|\.\d+)$/.test(part) : /^\d+$/.test(part),
  );
  if (!fits || parts.length > 3) return null;
  return parts.reduce((seconds, part) => 60 * seconds + Number(part), 0);
}
