/** Elements in few words. */

type Value = string | number | boolean | null | ((event: never) => void);

/** An element with attributes; those that begin with "on" are listeners, null and false are left out. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, Value> = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") {
      element.addEventListener(name.slice(2), value as (event: Event) => void);
    } else if (value !== null && value !== false) {
      element.setAttribute(name, value === true ? "" : String(value));
    }
  }
  element.append(...children);
  return element;
}

export function need<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (element === null) throw new Error(`the page has no #${id}`);
  return element as T;
}

/** Changes a text only when it differs, so that nothing is laid out in vain. */
export function setText(element: HTMLElement, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** A button that does nothing now; unlike a disabled one it keeps the focus. */
export function setOff(button: HTMLElement, off: boolean): void {
  if (off) button.setAttribute("aria-disabled", "true");
  else button.removeAttribute("aria-disabled");
}

/**
 * Fills an element anew only when what it shows has changed: what is replaced loses the focus, and is
 * read aloud again.
 */
export class Filled {
  private shown = "";

  constructor(readonly element: HTMLElement) {}

  show(what: unknown, make: () => (Node | string)[]): void {
    const key = JSON.stringify(what);
    if (key === this.shown) return;
    this.shown = key;
    this.element.replaceChildren(...make());
  }
}

const kIcons: Record<string, string> = {
  fit: "M4 9V5a1 1 0 0 1 1-1h4M15 4h4a1 1 0 0 1 1 1v4M20 15v4a1 1 0 0 1-1 1h-4M9 20H5a1 1 0 0 1-1-1v-4",
  follow: "M12 3v3M12 18v3M3 12h3M18 12h3M12 7a5 5 0 1 0 0 10a5 5 0 1 0 0-10M12 11.5v1",
  plus: "M12 5v14M5 12h14",
  minus: "M5 12h14",
  north: "M12 3l5 16l-5-4l-5 4z",
  measure: "M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l2.5 2.5M13 6l2 2",
  camera: "M4 8h3l2-3h6l2 3h3v11H4zM12 10a3.5 3.5 0 1 0 0 7a3.5 3.5 0 1 0 0-7",
  help: "M12 3a9 9 0 1 0 0 18a9 9 0 1 0 0-18M9.5 9.5a2.5 2.5 0 1 1 3.5 2.3c-.8.4-1 .9-1 1.7M12 16.6v.2",
  sun: "M12 8a4 4 0 1 0 0 8a4 4 0 1 0 0-8M12 2.5V4M12 20v1.5M2.5 12H4M20 12h1.5M5.3 5.3l1 1M17.7 17.7l1 1M5.3 18.7l1-1M17.7 6.3l1-1",
  moon: "M20 14.5A8.5 8.5 0 0 1 9.5 4a8.5 8.5 0 1 0 10.5 10.5z",
  system: "M4 5h16v11H4zM9 20h6M12 16v4",
  panels: "M4 6h16M4 12h16M4 18h16",
  play: "M7 4.500v15l12-7.500z",
  pause: "M8 5v14M16 5v14",
  back: "M17 5l-9 7l9 7zM6 5v14",
  forward: "M7 5l9 7l-9 7zM18 5v14",
  close: "M6 6l12 12M18 6L6 18",
  zoom: "M11 4a7 7 0 1 0 0 14a7 7 0 1 0 0-14M16 16l5 5M11 8v6M8 11h6",
  left: "M15 5l-7 7l7 7",
  right: "M9 5l7 7l-7 7",
  good: "M4 12.500l5 5L20 6.5",
  doubtful: "M12 4L2.5 20h19zM12 10v4.500M12 17.200v.1",
  bad: "M8 3h8l5 5v8l-5 5H8l-5-5V8zM9 9l6 6M15 9l-6 6",
};

const kSvg = "http://www.w3.org/2000/svg";

export function icon(name: string): SVGSVGElement {
  const svg = document.createElementNS(kSvg, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(kSvg, "path");
  path.setAttribute("d", kIcons[name] ?? "");
  svg.append(path);
  return svg;
}

export function iconButton(
  name: string,
  label: string,
  key: string,
  act: () => void,
): HTMLButtonElement {
  const title = key ? `${label} (${key})` : label;
  const attributes = { type: "button", class: "icon", title, "aria-label": label, onclick: act };
  return h("button", attributes, icon(name));
}

/** A line with a mark, as the map draws closures: told by pattern and shape, not by colour alone. */
export function swatch(colour: string, dash: string, mark: string, width = 34): SVGSVGElement {
  const svg = document.createElementNS(kSvg, "svg");
  svg.setAttribute("class", "swatch");
  svg.setAttribute("viewBox", `0 0 ${width} 14`);
  svg.setAttribute("aria-hidden", "true");
  const shape = (d: string, dashes: string, fill: string) => {
    const path = document.createElementNS(kSvg, "path");
    path.setAttribute("d", d);
    path.setAttribute("stroke", fill === "none" ? colour : "none");
    path.setAttribute("fill", fill);
    path.setAttribute("stroke-width", "1.75");
    if (dashes) path.setAttribute("stroke-dasharray", dashes);
    svg.append(path);
  };
  if (dash !== "none") shape(`M1 7H${width - 1}`, dash, "none");
  const x = width / 2;
  const circle = (r: number) =>
    `M${x - r} 7a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
  if (mark === "disc") shape(circle(3), "", colour);
  if (mark === "ring") shape(circle(3.5), "", "none");
  if (mark === "cross") shape(`M${x - 4} 3l8 8m0-8l-8 8`, "", "none");
  if (mark === "diamond") shape(`M${x - 5} 7l5-5l5 5l-5 5z`, "", "none");
  if (mark === "box") shape(`M${x - 9} 2h18v10h-18z`, "", "none");
  if (mark === "arrow") shape(`M${x - 5} 2l11 5l-11 5l3-5z`, "", colour);
  if (mark === "dots") {
    for (const [dx, y] of [
      [-9, 10],
      [-3, 8],
      [3, 6],
      [9, 3],
    ] as const) {
      shape(`M${x + dx - 1.5} ${y}a1.5 1.5 0 1 0 3 0a1.5 1.5 0 1 0 -3 0`, "", colour);
    }
  }
  return svg;
}
