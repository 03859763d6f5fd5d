// Light or dark, as the reader's system says; always light on paper. What is drawn on canvases
// needs the colours as values.
const kDark = matchMedia('(prefers-color-scheme: dark)');
const kListeners: (() => void)[] = [];
let printing = false;

export function isDark(): boolean {
  return kDark.matches && !printing;
}

/** The value of a custom property of the style sheet, such as --ink. */
export function themeColour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

export function onThemeChange(listener: () => void): void {
  kListeners.push(listener);
}

function apply(): void {
  document.documentElement.classList.toggle('dark', isDark());
  for (const listener of kListeners) listener();
}

export function watchTheme(): void {
  kDark.addEventListener('change', apply);
  addEventListener('beforeprint', () => {
    printing = true;
    apply();
  });
  addEventListener('afterprint', () => {
    printing = false;
    apply();
  });
  apply();
}
