// A page that follows its program: while that is built again and again, the page of the latest build takes its place.
"use strict";

/** Period in which the latest build is asked for, in milliseconds. */
const ASK_MS = 400;

/** Asks the script beside the page, again and again, which build is the latest; a page from the disk can load nothing else. */
function follow({ follow: script, stamp: own }) {
  if (!script) return;
  const here = decodeURIComponent(window.location.pathname.split("/").pop());
  window.tweezeBuilt = ({ stamp, pages }) => {
    const latest = pages.includes(here) ? here : pages[0];
    if (latest !== here) window.location.replace(encodeURIComponent(latest));
    else if (stamp !== own) window.location.reload();
  };
  const ask = () => {
    const element = document.createElement("script");
    element.src = `${encodeURIComponent(script)}?${Date.now()}`;
    // Taken away while a build replaces it, it is there again the next time.
    element.onload = element.onerror = () => element.remove();
    document.head.append(element);
  };
  window.setInterval(ask, ASK_MS);
}
