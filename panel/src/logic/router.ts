/** `#/robots/NAME/VIEW` and `#/VIEW`: what is open can be kept as a bookmark. */

export interface Route {
  robot: string | null;
  view: string;
}

const kPart = /^[a-z0-9-]{1,63}$/;

/** @param views  those there are; the first one where the address names none of them */
export function parseRoute(hash: string, views: readonly string[]): Route {
  const parts = hash.replace(/^#\/?/, '').split('/');
  const fallback = views[0] ?? '';
  const view = (name: string | undefined) => (name && views.includes(name) ? name : fallback);
  if (parts[0] === 'robots') {
    const robot = parts[1] && kPart.test(parts[1]) ? parts[1] : null;
    return { robot, view: view(parts[2]) };
  }
  return { robot: null, view: view(parts[0]) };
}

export function routeText(route: Route): string {
  return route.robot ? `#/robots/${route.robot}/${route.view}` : `#/${route.view}`;
}

/** The token that a start link carries; the address bar shall not keep it. */
export function tokenOf(hash: string): string | null {
  const match = /^#(?:.*&)?token=([A-Za-z0-9._~-]{8,256})(?:&|$)/.exec(hash);
  return match ? match[1]! : null;
}
