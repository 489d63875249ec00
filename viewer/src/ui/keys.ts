/** Keys that act wherever the focus is, but for where a reader writes or chooses. */

export type KeyActions = Record<string, () => void>;

const kOwnArrows = "input, select, textarea, [role=tablist] *, [role=grid]";

export function listenToKeys(actions: KeyActions, busy: () => boolean): void {
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.altKey) return;
    if (busy() && event.key !== "?") return;
    const target = event.target instanceof Element ? event.target : document.body;
    const writes = target.matches("select, textarea, input[type=text]");
    if (writes && event.key !== "Escape") return;
    // A button, a box or a switch is worked with space, sliders and lists with arrows.
    if (
      event.key === " " &&
      target.matches("button, input[type=checkbox], input[type=radio], summary")
    )
      return;
    if (event.key.startsWith("Arrow") && target.matches(kOwnArrows)) return;
    if (event.key === "Enter") return;
    const control = event.ctrlKey || event.metaKey;
    const shift = event.shiftKey && (control || event.key.startsWith("Arrow"));
    const name = `${control ? "Ctrl+" : ""}${shift ? "Shift+" : ""}${event.key}`;
    const action = actions[name] ?? (control ? undefined : actions[name.toLowerCase()]);
    if (action === undefined) return;
    event.preventDefault();
    action();
  });
}
