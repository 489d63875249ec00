import { h } from "./dom.ts";

export interface Tab {
  id: string;
  label: string;
  panel: HTMLElement;
}

/** Panels of which one is shown; arrow keys go from tab to tab. */
export class Tabs {
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private readonly counts = new Map<string, HTMLElement>();
  current = "";

  constructor(
    list: HTMLElement,
    host: HTMLElement,
    private readonly tabs: Tab[],
    private readonly shown: (id: string) => void,
  ) {
    for (const { id, label, panel } of tabs) {
      const count = h("span", { class: "count" });
      const button = h(
        "button",
        {
          type: "button",
          role: "tab",
          id: `tab-${id}`,
          "aria-controls": `panel-${id}`,
          onclick: () => this.show(id),
        },
        label,
        count,
      );
      panel.id = `panel-${id}`;
      panel.classList.add("panel");
      panel.setAttribute("role", "tabpanel");
      panel.setAttribute("aria-labelledby", `tab-${id}`);
      panel.tabIndex = 0;
      list.append(button);
      host.append(panel);
      this.buttons.set(id, button);
      this.counts.set(id, count);
    }
    list.addEventListener("keydown", (event) => this.key(event));
    this.show(tabs[0]?.id ?? "");
  }

  show(id: string): void {
    this.current = id;
    for (const tab of this.tabs) {
      const chosen = tab.id === id;
      const button = this.buttons.get(tab.id);
      button?.setAttribute("aria-selected", String(chosen));
      if (button) button.tabIndex = chosen ? 0 : -1;
      tab.panel.hidden = !chosen;
    }
    this.shown(id);
  }

  /** Whether there is such a tab at all; a hidden one is left out by keys, too. */
  setThere(id: string, there: boolean): void {
    const button = this.buttons.get(id);
    if (button === undefined || button.hidden === !there) return;
    button.hidden = !there;
    if (!there && this.current === id) this.show(this.tabs[0]?.id ?? "");
  }

  isThere(id: string): boolean {
    return this.buttons.get(id)?.hidden === false;
  }

  focus(): void {
    this.buttons.get(this.current)?.focus();
  }

  setCount(id: string, count: number): void {
    const element = this.counts.get(id);
    if (element) element.textContent = count > 0 ? String(count) : "";
  }

  private key(event: KeyboardEvent): void {
    const tabs = this.tabs.filter((tab) => this.isThere(tab.id));
    const at = tabs.findIndex((tab) => tab.id === this.current);
    const last = tabs.length - 1;
    const to: Record<string, number> = {
      ArrowLeft: at === 0 ? last : at - 1,
      ArrowRight: at === last ? 0 : at + 1,
      Home: 0,
      End: last,
    };
    const next = to[event.key];
    if (next === undefined) return;
    event.preventDefault();
    event.stopPropagation();
    this.show(tabs[next]?.id ?? this.current);
    this.focus();
  }
}
